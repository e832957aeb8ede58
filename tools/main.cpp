#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>

#include "core/interruption.hpp"
#include "tools/commands.hpp"
#include "tools/console.hpp"

namespace {

/// Whether all results reached their place: what is buffered shows a full disk only when it is flushed.
bool written() {
    std::cout.flush();
    return std::cout && std::fflush(stdout) == 0 && !std::ferror(stdout);
}

}  // namespace

int main(int argc, char** argv) {
    using namespace mien::tools;
    mien::end_in_order([] { fail("stopped by a signal; nothing unfinished is left"); });
    CLI::App mien("mien: streaming codec for detailed human facial performances", "mien");
    mien.set_version_flag("--version", "mien " MIEN_VERSION);
    mien.require_subcommand(1);
    mien.footer("Every command has its own --help. Serve streams with mien-serve, watch them with mien-play.");
    int code = kDone;
    add_stage(mien, code);
    add_check(mien, code);
    add_encode(mien, code);
    add_decode(mien, code);
    add_info(mien, code);
    add_verify(mien, code);
    add_train(mien, code);
    add_remap(mien, code);
    add_evaluate(mien, code);
    add_live(mien, code);
    add_send(mien, code);
    if (argc > 1 && argv[1][0] != '-') {
        std::string commands;
        bool known = false;
        for (const CLI::App* command : mien.get_subcommands({})) {
            commands += (commands.empty() ? "" : ", ") + command->get_name();
            known = known || command->get_name() == argv[1];
        }
        if (!known) return misused(fmt::format("there is no command '{}', only {}", argv[1], commands));
    }
    try {
        mien.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        code = mien.exit(error) == 0 ? kDone : kMisused;
    }
    return code != kDone || written() ? code : fail("cannot write to standard output: is the disk full?");
}
