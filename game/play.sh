#!/usr/bin/env bash
# Installs what is missing, builds, and plays Hourglass. Where no window can be opened, plays the
# recorded win of level 1 instead and leaves frames, a contact sheet and statistics in
# build/captures/level1_win.
# Usage: game/play.sh [--help] [flags of hourglass]
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
game=$root/build/bin/hourglass
for flag; do
  case "$flag" in
    --help|-h)
      sed -n '2,5s/^# //p' "$0"
      if [ -x "$game" ]; then "$game" --help; else echo "The flags are listed here once it is built."; fi
      exit 0 ;;
  esac
done
"$root/engine/build.sh" --tests off --dir "$root/build" --target hourglass
[ $# = 0 ] || exec "$game" "$@"

# One line of what the game says is kept back: why there is no window, if that is how it ends.
said=$(mktemp)
trap 'rm -f "$said"' EXIT
status=0
exec 3> >(trap '' INT; tee "$said" | grep --line-buffered -v 'no window context: ' >&2)
saying=$!
"$game" --context window 2>&3 3>&- || status=$?
exec 3>&-
wait "$saying" || true
why=$(sed -n 's/.*no window context: //p' "$said")
[ -n "$why" ] || exit "$status"
out=$root/build/captures/level1_win
mkdir -p "$out"
echo "No window ($why): playing the recorded win of level 1."
"$game" --replay "$root/tests/game/replays/level1_win.replay" --context egl --size 960x540 \
  --capture "$out" --every 60 --stats "$out/stats.json"
