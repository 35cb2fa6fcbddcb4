// How many simulation ticks a rendered frame owes: fixed step, interpolation, bounded catch-up.
#pragma once

namespace scree {

class FixedStep {
 public:
  // At most `max_ticks` ticks are owed to one frame. What is beyond is dropped, so that a machine
  // too slow for the simulation slows the game down and never falls further behind.
  explicit FixedStep(double step_s = 1.0 / 60.0, int max_ticks = 5);

  // Adds the real time since the last call, seconds; returns how many ticks to run now. Negative
  // and non-finite times count as 0.
  int advance(double elapsed_s);
  // Where the frame lies between the last two ticks: 0 (at the previous one) up to, not
  // including, 1.
  float alpha() const;
  // Real time that was dropped so far, seconds.
  double droppedSeconds() const { return dropped_s_; }
  // Forgets the time that is owed: after a load or a pause of the program.
  void reset() { owed_s_ = 0; }

 private:
  double step_s_;
  int max_ticks_;
  double owed_s_ = 0;  // below step_s_ between calls
  double dropped_s_ = 0;
};

}  // namespace scree
