#include <sys/utsname.h>

#include <Eigen/Core>
#include <chrono>
#include <fstream>
#include <numeric>
#include <thread>

#include "bench/timing.hpp"

namespace mien::bench {
namespace {

double seconds(auto&& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double read_gbytes_per_s(std::size_t bytes, int runs) {
    const std::vector<std::uint64_t> buffer(bytes / 8, 1);
    std::vector<double> rates;
    volatile std::uint64_t sink = 0;
    for (int run = 0; run < runs; ++run)
        rates.push_back(double(bytes) / 1e9 / seconds([&] {
                            // Four sums at once, so that the memory and not one chain of additions is the limit.
                            std::uint64_t sums[4] = {};
                            for (std::size_t i = 0; i + 3 < buffer.size(); i += 4)
                                for (std::size_t j = 0; j < 4; ++j) sums[j] += buffer[i + j];
                            sink = sums[0] + sums[1] + sums[2] + sums[3];
                        }));
    return quantile(rates, 0.5);
}

double sgemm_gflops(Eigen::Index n, int runs) {
    const Eigen::MatrixXf a = Eigen::MatrixXf::Constant(n, n, 0.5f), b = Eigen::MatrixXf::Constant(n, n, 0.25f);
    Eigen::MatrixXf c(n, n);
    std::vector<double> rates;
    for (int run = 0; run < runs; ++run)
        rates.push_back(2e-9 * double(n) * double(n) * double(n) / seconds([&] { c.noalias() = a * b; }));
    return quantile(rates, 0.5);
}

std::string processor() {
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);)
        if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
    return "unknown processor";
}

}  // namespace

Machine measure_machine(bool quick) {
    Machine machine;
    machine.processor = processor();
    machine.cores = int(std::thread::hardware_concurrency());
    utsname name{};
    if (uname(&name) == 0) machine.system = std::string(name.sysname) + " " + name.release + " " + name.machine;
#ifdef __clang__
    machine.compiler = "Clang " __clang_version__;
#else
    machine.compiler = "GCC " __VERSION__;
#endif
    machine.read_gbytes_per_s = read_gbytes_per_s(std::size_t(quick ? 32 : 256) << 20, quick ? 3 : 7);
    machine.sgemm_gflops = sgemm_gflops(quick ? 128 : 768, quick ? 3 : 7);
    return machine;
}

}  // namespace mien::bench
