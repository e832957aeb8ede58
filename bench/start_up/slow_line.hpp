#pragma once

#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

/// A TCP line of a known rate on this machine: what a viewer gets through it comes as it would from afar, but for the delay.
class SlowLine {
public:
    /// To `server` of this machine. bits_per_second: from the server; 0: as many as come. Throws EnvironmentError.
    SlowLine(std::uint16_t server, double bits_per_second);
    ~SlowLine();
    SlowLine(const SlowLine&) = delete;
    SlowLine& operator=(const SlowLine&) = delete;

    std::uint16_t port() const { return port_; }   ///< where it begins

private:
    void accept();
    void pass(int from, int to, double bits_per_second);

    std::uint16_t server_, port_ = 0;
    double rate_;
    int listener_ = -1;
    std::atomic<bool> stop_ = false;
    std::vector<int> sockets_;
    std::vector<std::thread> passing_;   // of the accepting thread, until it has ended
    std::thread accepting_;
};
