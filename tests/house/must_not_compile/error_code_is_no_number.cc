// error: cannot convert 'int' to|cannot initialize .* with an (rvalue|lvalue) of type 'int'
#include "sinew/core/error.h"
#include "sinew/core/error_code.h"

using namespace sinew;

int main() {
#ifdef MUST_NOT_COMPILE
  const Error error{.code = 3};
#else
  const Error error{.code = ErrorCode::kJointLimit};
#endif
  return error.index;
}
