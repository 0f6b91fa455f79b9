# Starts and stops a treeline-server for a script. Sourced after common.sh.
# shellcheck shell=bash

server_pid=''

# Whatever happens, no server is left behind.
stop_server() {
  local pid=$server_pid
  [[ -n "$pid" ]] || return 0
  server_pid=''
  kill -TERM "$pid" 2>/dev/null || true
  wait "$pid"
}

# start_server PROGRAM MODELS LOG: sets server_pid and server_address.
start_server() {
  local program=$1 models=$2 log=$3 waited=0
  # Else an earlier run's address might be read before the server empties it.
  : >"$log"
  "$program" --models "$models" --load-all --listen 127.0.0.1:0 \
    --admin-listen "" --http-listen "" >"$log" 2>&1 &
  server_pid=$!
  until server_address=$(sed -n \
    's/.*listening on \(127\.0\.0\.1:[0-9][0-9]*\).*/\1/p' "$log") &&
    [[ -n "$server_address" ]]; do
    if ! kill -0 "$server_pid" 2>/dev/null || ((waited >= 600)); then
      cat "$log" >&2
      die "the server did not start; what it said is above"
    fi
    sleep 0.1
    waited=$((waited + 1))
  done
  server_address=${server_address%%$'\n'*}
}
