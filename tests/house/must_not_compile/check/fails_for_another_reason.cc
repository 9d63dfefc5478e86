// error: invalid operands
int main() {
#ifdef MUST_NOT_COMPILE
  return undeclared;
#else
  return 0;
#endif
}
