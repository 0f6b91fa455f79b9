# What the scripts share. Sourced, after `set -euo pipefail`.
# shellcheck shell=bash

TREELINE_ROOT=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
# shellcheck disable=SC2034  # for those who source this
readonly TREELINE_ROOT

say() { printf '%s\n' "$*"; }

# Ends the script: what was wrong, and what to do.
die() {
  printf '%s: %s\n' "$(basename "$0")" "$*" >&2
  exit 1
}

# Parallel jobs: one a processor, but each with 2 GiB of memory that is free
# now, since a file that includes gRPC takes more than one. TREELINE_JOBS
# overrides.
parallel_jobs() {
  local processors available_kib by_memory
  if [[ -n "${TREELINE_JOBS:-}" ]]; then
    [[ "$TREELINE_JOBS" =~ ^[1-9][0-9]*$ ]] ||
      die "TREELINE_JOBS=$TREELINE_JOBS is not a number of jobs"
    printf '%s\n' "$TREELINE_JOBS"
    return
  fi
  processors=$(nproc)
  available_kib=$(awk '/^MemAvailable:/ {print $2}' /proc/meminfo)
  by_memory=$((available_kib / (2 * 1024 * 1024)))
  ((by_memory >= 1)) || by_memory=1
  printf '%s\n' $((processors < by_memory ? processors : by_memory))
}

# stage TITLE PROGRAM...: says what runs and how long it took, and passes the
# program's status on. Not for shell functions of several commands: `set -e`
# does not hold inside them.
stage() {
  local title=$1 start=$SECONDS status=0
  shift
  printf '\n== %s\n' "$title"
  "$@" || status=$?
  if ((status != 0)); then
    printf '== %s: FAILED (status %d) after %d s\n' "$title" "$status" \
      $((SECONDS - start)) >&2
    return "$status"
  fi
  printf '== %s: %d s\n' "$title" $((SECONDS - start))
}
