// A run may be cut short and still leaves a chart of what there is.
#pragma once

namespace farfield::bench {

/// From now on the first SIGINT or SIGTERM only sets what was_interrupted() gives; the second ends the program.
void catch_interrupts();
bool was_interrupted();

}  // namespace farfield::bench
