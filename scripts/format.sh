#!/usr/bin/env bash
# format.sh [--check]: lays out all C++ with clang-format 19, or says which files are not.
# shellcheck source=scripts/lib.sh
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

scripts/packages.sh format
mapfile -t files < <(find src tests fuzz bench firmware -name '*.h' -o -name '*.cc' -o -name '*.c' \
  2>/dev/null)
if [[ ${1:-} == --check ]]; then
  step "format of ${#files[@]} files" format clang-format-19 --dry-run -Werror "${files[@]}"
else
  step "format ${#files[@]} files" format clang-format-19 -i "${files[@]}"
fi
