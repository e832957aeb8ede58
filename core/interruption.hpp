#pragma once

#include <functional>

namespace mien {

/// From now on SIGINT, SIGTERM and SIGHUP (those that are not ignored) end the process in order: what is unfinished
/// (core/unfinished.hpp) is removed, `say` tells the user, and the signal takes its usual effect. A thread of its own waits for
/// them, so call it first in main(): threads that run already would still be struck.
void end_in_order(std::function<void()> say);

/// While it lives, a first signal is only remembered, so that what goes on can be brought to a good end; a second one ends the
/// process. SIGINT and SIGTERM ask even where they were ignored, as in the background of a script. Only after end_in_order(), and
/// one at a time.
class StopRequest {
public:
    StopRequest();
    StopRequest(const StopRequest&) = delete;
    StopRequest& operator=(const StopRequest&) = delete;
    ~StopRequest();
    bool asked() const { return signal() != 0; }
    static int signal();   ///< that came; 0: none, or nobody waits for one
};

}  // namespace mien
