#!/usr/bin/env bash
# run_test.sh PACKAGE WORK PROGRAM ARGUMENT...: runs a test of the Java client,
# if it could be built. {jar} is the client, {jars} it with its libraries and
# tests.
set -euo pipefail

readonly package=$1 work=$2
shift 2
jar=$(find "$package" -name 'treeline-client-*[0-9].jar' 2>/dev/null || true)
if [[ -z "$jar" ]]; then
  printf 'SKIPPED: the client could not be built here (test java.build)\n' >&2
  exit 77
fi
jars=$jar:$work/tests
for name in protobuf junit4 hamcrest; do
  jars+=:/usr/share/java/$name.jar
done
words=("${@//\{jars\}/$jars}")
words=("${words[@]//\{jar\}/$jar}")
exec "${words[@]}"
