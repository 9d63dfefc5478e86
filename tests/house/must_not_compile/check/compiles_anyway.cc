// error: never seen
int main() {
  return 0;
}
