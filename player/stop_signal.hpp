#pragma once

namespace mien::player {

/// Between construction and destruction SIGINT and SIGTERM end the program at a place where nothing is left half done; a second one ends
/// it at once. One at a time.
class StopSignal {
public:
    StopSignal();
    ~StopSignal();
    StopSignal(const StopSignal&) = delete;
    StopSignal& operator=(const StopSignal&) = delete;

    static int number();   ///< the signal that came; 0: none
};

}  // namespace mien::player
