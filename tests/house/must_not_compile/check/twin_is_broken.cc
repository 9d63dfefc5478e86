// error: never seen
int main() {
  return undeclared;
}
