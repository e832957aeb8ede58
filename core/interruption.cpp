#include "core/interruption.hpp"

#include <signal.h>

#include <atomic>
#include <cassert>
#include <thread>

#include "core/unfinished.hpp"

namespace mien {
namespace {

enum class Stop { not_wanted, wanted, asked };
std::atomic<Stop> stop = Stop::not_wanted;

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
    for (const int signal : {SIGINT, SIGTERM})
        if (sigismember(&ignored, signal)) ::signal(signal, SIG_DFL);   // blocked, and to be waited for
    std::thread([signals, ignored, say = std::move(say)] {
        for (int signal = 0; sigwait(&signals, &signal) == 0;) {
            Stop wanted = Stop::wanted;
            if (!stop.compare_exchange_strong(wanted, Stop::asked) && !sigismember(&ignored, signal)) end_by(signal, say);
        }
    }).detach();
}

StopRequest::StopRequest() {
    assert(stop == Stop::not_wanted);
    stop = Stop::wanted;
}
StopRequest::~StopRequest() { stop = Stop::not_wanted; }
bool StopRequest::asked() const { return stop == Stop::asked; }

}  // namespace mien
