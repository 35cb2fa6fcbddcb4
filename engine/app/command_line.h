// The flags that every program on App shares, with their checks.
#pragma once

#include "engine/app/options.h"
#include "engine/core/result.h"

namespace CLI {
class App;
}

namespace scree {

// Adds --size, --context, --threads, --replay, --record, --bindings, --capture, --frames, --every,
// --exr, --truth, --hash-log, --stats, --trace, --print-frame, --ticks and --gl-debug to `cli`.
// `options` must outlive the parse. Bad values are refused by CLI11 with one line.
void addCommonFlags(CLI::App& cli, AppOptions& options);

// Checks what single flags cannot: combinations. The error names the flags.
Status checkOptions(const AppOptions& options);

}  // namespace scree
