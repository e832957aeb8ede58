#include "core/interruption.hpp"

#include <signal.h>

#include <algorithm>
#include <atomic>
#include <cassert>
#include <thread>

#include "core/unfinished.hpp"

namespace mien {
namespace {

// What a StopRequest waits for: nothing while there is none, then no signal, then the one that came.
constexpr int kNotWanted = -1, kNone = 0;
std::atomic<int> stop = kNotWanted;

void end_by(int signal, const std::function<void()>& say) {
    abandon_unfinished();
    say();
    ::signal(signal, SIG_DFL);
    sigset_t one;
    sigemptyset(&one);
    sigaddset(&one, signal);
    pthread_sigmask(SIG_UNBLOCK, &one, nullptr);
    ::raise(signal);
}

}  // namespace

void end_in_order(std::function<void()> say) {
    sigset_t signals, ignored;
    sigemptyset(&signals);
    sigemptyset(&ignored);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
        struct sigaction now {};
        // nohup ignores SIGHUP, and the background of a script SIGINT, on purpose. The latter still may ask to stop.
        if (sigaction(signal, nullptr, &now) == 0 && now.sa_handler == SIG_IGN) sigaddset(&ignored, signal);
        if (signal != SIGHUP || !sigismember(&ignored, signal)) sigaddset(&signals, signal);
    }
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);
    ::signal(SIGXFSZ, SIG_IGN);   // a file beyond the shell's limit is then a failed write, which is said and cleaned up after
    for (const int signal : {SIGINT, SIGTERM})
        if (sigismember(&ignored, signal)) ::signal(signal, SIG_DFL);   // blocked, and to be waited for
    std::thread([signals, ignored, say = std::move(say)] {
        for (int signal = 0; sigwait(&signals, &signal) == 0;) {
            int wanted = kNone;
            if (!stop.compare_exchange_strong(wanted, signal) && !sigismember(&ignored, signal)) end_by(signal, say);
        }
    }).detach();
}

StopRequest::StopRequest() {
    assert(stop == kNotWanted);
    stop = kNone;
}
StopRequest::~StopRequest() { stop = kNotWanted; }
int StopRequest::signal() { return std::max(kNone, stop.load()); }

}  // namespace mien
