// Pairs of timestamp queries in rings.
#include "engine/gpu/timers.h"

#include "engine/core/log.h"
#include "engine/gpu/counters.h"
#include "engine/gpu/gl.h"

namespace scree::gpu {

Timers::~Timers() {
  release();
}

int Timers::find(std::string_view name) {
  for (size_t i = 0; i < timers_.size(); ++i)
    if (timers_[i].name == name) return static_cast<int>(i);
  timers_.emplace_back().name = name;
  return static_cast<int>(timers_.size()) - 1;
}

const std::string& Timers::name(int timer) const {
  return timers_[static_cast<size_t>(timer)].name;
}

void Timers::begin(int timer) {
  Timer& t = timers_[static_cast<size_t>(timer)];
  if (t.pending == kDepth) take(t, false);
  if (t.pending == kDepth) return;
  if (t.queries[0] == 0) {
    glCreateQueries(GL_TIMESTAMP, 2 * kDepth, t.queries);
    counters().queries += 2 * kDepth;
  }
  glQueryCounter(t.queries[2 * t.next], GL_TIMESTAMP);
  t.open = true;
}

void Timers::end(int timer) {
  Timer& t = timers_[static_cast<size_t>(timer)];
  if (!t.open) return;
  glQueryCounter(t.queries[2 * t.next + 1], GL_TIMESTAMP);
  t.open = false;
  t.next = (t.next + 1) % kDepth;
  ++t.pending;
}

// Takes in the oldest measurement; false if there is none, or it is not there yet.
bool Timers::take(Timer& t, bool wait) {
  if (t.pending == 0) return false;
  const int slot = (t.next - t.pending + kDepth) % kDepth;
  const unsigned first = t.queries[2 * slot], last = t.queries[2 * slot + 1];
  if (!wait) {
    GLint there = 0;
    glGetQueryObjectiv(last, GL_QUERY_RESULT_AVAILABLE, &there);
    if (!there) return false;
  }
  GLuint64 begin_ns = 0, end_ns = 0;
  glGetQueryObjectui64v(first, GL_QUERY_RESULT, &begin_ns);
  glGetQueryObjectui64v(last, GL_QUERY_RESULT, &end_ns);
  --t.pending;
  // Clocks may step back when a GPU changes its frequency.
  t.last_ms = end_ns > begin_ns ? static_cast<double>(end_ns - begin_ns) * 1e-6 : 0.0;
  t.last_start_ns = static_cast<int64_t>(begin_ns);
  ++t.measurements;
  return true;
}

void Timers::poll() {
  for (Timer& t : timers_)
    while (take(t, false)) {
    }
}

void Timers::finish() {
  for (Timer& t : timers_)
    while (take(t, true)) {
    }
}

double Timers::lastMs(int timer) const {
  return timers_[static_cast<size_t>(timer)].last_ms;
}
int64_t Timers::lastStartNs(int timer) const {
  return timers_[static_cast<size_t>(timer)].last_start_ns;
}
uint64_t Timers::measurements(int timer) const {
  return timers_[static_cast<size_t>(timer)].measurements;
}

void Timers::release() {
  for (Timer& t : timers_) {
    if (t.queries[0] != 0) glDeleteQueries(2 * kDepth, t.queries);
    for (unsigned& query : t.queries) query = 0;
    t.next = t.pending = 0;
    t.open = false;
  }
}

}  // namespace scree::gpu
