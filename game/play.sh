#!/usr/bin/env bash
# Installs what is missing, builds, and plays Hourglass. With no display, plays the recorded win of
# level 1 instead and leaves frames, a contact sheet and statistics in build/captures/level1_win.
# Usage: game/play.sh [flags of hourglass]
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
"$root/engine/build.sh" --tests off --dir "$root/build" --target hourglass
game=$root/build/bin/hourglass
if [ $# -gt 0 ] || [ -n "${DISPLAY:-}${WAYLAND_DISPLAY:-}" ]; then
  exec "$game" "$@"
fi
out=$root/build/captures/level1_win
mkdir -p "$out"
echo "No display: playing the recorded win of level 1."
"$game" --replay "$root/tests/game/replays/level1_win.replay" --context egl --size 960x540 \
  --capture "$out" --every 60 --stats "$out/stats.json"
