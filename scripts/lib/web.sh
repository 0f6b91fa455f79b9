# What builds web folders: node, npm, and packages as package-lock.json says.
# Sourced after common.sh, `set -euo pipefail`.
# shellcheck shell=bash

# The status of a script that could do nothing here, though nothing is wrong.
readonly NOTHING_DONE=77

# Ends the script: why nothing was built, and what to do.
give_up() {
  printf '%s: SKIPPED: %s\n' "$(basename "$0")" "$*" >&2
  exit "$NOTHING_DONE"
}

# check_node WHAT: ends the script where WHAT cannot be built.
check_node() {
  local program version
  for program in node npm; do
    command -v "$program" >/dev/null || give_up "there is no $program here.
Install node 18 or newer with npm (on Debian 12: apt-get install nodejs npm)
and run scripts/$(basename "$0") again."
  done
  version=$(node --version)
  version=${version#v}
  ((${version%%.*} >= 18)) ||
    give_up "node $version is too old; $1 needs 18 or newer."
}

# copy_web SOURCES WORK: packages and what is built of the sources stay out of
# the source tree.
copy_web() {
  mkdir -p "$2"
  rm -rf "${2:?}/src" "$2/public" "$2/unit" "$2/fixtures"
  cp -R "$1/." "$2/"
}

# share_web WORK NAME...: what pages have in common, files and folders of
# common/web.
share_web() {
  local work=$1 name
  shift
  mkdir -p "$work/src/common"
  for name in "$@"; do
    cp -R "$TREELINE_ROOT/common/web/$name" "$work/src/common/"
  done
}

# fetch_packages WORK: again only when package-lock.json has changed.
fetch_packages() {
  local errors=$1/npm-errors.txt
  if cmp -s "$1/package-lock.json" "$1/node_modules/.fetched"; then
    return
  fi
  if ! (cd "$1" && npm ci --prefer-offline --no-audit --no-fund \
    --ignore-scripts >/dev/null 2>"$errors"); then
    if grep -qE 'ENOTFOUND|EAI_AGAIN|ECONNREFUSED|ECONNRESET|ETIMEDOUT|EHOSTUNREACH|ENETUNREACH' \
      "$errors"; then
      cat "$errors" >&2
      give_up "npm's registry cannot be reached."
    fi
    cat "$errors" >&2
    die "npm ci failed; its words are above"
  fi
  cp "$1/package-lock.json" "$1/node_modules/.fetched"
}

# check_web WHAT [--unit]: the types of what is in this folder and, with
# --unit, its unit tests.
check_web() {
  node_modules/.bin/tsc --noEmit || die "the types of $1 are wrong"
  [[ "${2:-}" == --unit ]] || return 0
  node_modules/.bin/tsc -p tsconfig.unit.json ||
    die "the types of the unit tests of $1 are wrong"
  node --test unit/*/*.test.js || die "unit tests of $1 failed"
}

# check_protoc: ends the script where messages cannot be generated.
check_protoc() {
  command -v protoc >/dev/null || give_up "there is no protoc here.
Install it (on Debian 12: apt-get install protobuf-compiler) and run
scripts/$(basename "$0") again."
}

# generate_client_messages WORK FOLDER: TypeScript of the messages that
# client/typescript needs.
generate_client_messages() {
  local protos=$TREELINE_ROOT/proto
  mkdir -p "$2"
  protoc --proto_path="$protos" \
    --plugin=protoc-gen-es="$1/node_modules/.bin/protoc-gen-es" \
    --es_out="$2" --es_opt=target=ts,import_extension=js \
    "$protos"/treeline/v1/{camera,frame,geometry,relocalization,scenes}.proto \
    "$protos/google/rpc/status.proto" ||
    die "no TypeScript could be made of proto/treeline/v1"
}
