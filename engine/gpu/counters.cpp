// The process's counters.
#include "engine/gpu/counters.h"

namespace scree::gpu {

Counters& counters() {
  static Counters instance;
  return instance;
}

Counters operator-(const Counters& after, const Counters& before) {
  Counters d = after;
  d.draws -= before.draws;
  d.dispatches -= before.dispatches;
  d.barriers -= before.barriers;
  d.programs -= before.programs;
  d.reloads -= before.reloads;
  d.buffers -= before.buffers;
  d.buffer_bytes -= before.buffer_bytes;
  d.textures -= before.textures;
  d.texture_bytes -= before.texture_bytes;
  d.framebuffers -= before.framebuffers;
  d.queries -= before.queries;
  d.bytes_uploaded -= before.bytes_uploaded;
  d.readbacks -= before.readbacks;
  d.stream_waits -= before.stream_waits;
  d.state_changes -= before.state_changes;
  d.binds -= before.binds;
  return d;
}

}  // namespace scree::gpu
