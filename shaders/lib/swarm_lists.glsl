// Where the counts before each run and block of runs are kept: by run, then behind all runs by block;
// sixteen numbers each, one a representation.
#include "shared/swarm.h"

uint blockCount(uint run_count) { return (run_count + kBlockRuns - 1u) / kBlockRuns; }
uint prefixOfRun(uint run) { return run * kRepresentations; }
uint prefixOfBlock(uint block, uint run_count) { return (run_count + block) * kRepresentations; }
