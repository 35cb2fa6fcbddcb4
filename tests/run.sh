#!/usr/bin/env bash
# Installs what is missing, builds, and runs the tests.
# Usage: tests/run.sh [--all] [--sanitize address|thread] [--update-goldens] [ctest flags]
#   --all               also the slow tier: stress, long replays, reuse from outside
#   --sanitize KIND     in a build of its own with ASan and UBSan, or TSan
#   --update-goldens    let image tests write new goldens instead of comparing
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
dir=$root/build sanitize="" select=(-LE stress)
while [ $# -gt 0 ]; do
  case "$1" in
    --all) select=(); shift ;;
    --sanitize) sanitize=${2:?--sanitize needs address or thread}; dir=$root/build-$sanitize; shift 2 ;;
    --update-goldens) export SCREE_UPDATE_GOLDENS=1; shift ;;
    --help|-h) sed -n '2,6s/^# //p' "$0"; exit 0 ;;
    *) break ;;
  esac
done
"$root/engine/build.sh" --dir "$dir" --tests on ${sanitize:+--sanitize "$sanitize"}
cd "$dir"
exec ctest --output-on-failure "${select[@]}" "$@"
