#pragma once

#include <CLI/CLI.hpp>

/// The subcommands of `mien`. Each adds itself to the command line; parsing it leaves the exit code in `code`.
namespace mien::tools {

void add_stage(CLI::App& mien, int& code);
void add_check(CLI::App& mien, int& code);
void add_encode(CLI::App& mien, int& code);
void add_decode(CLI::App& mien, int& code);
void add_info(CLI::App& mien, int& code);
void add_verify(CLI::App& mien, int& code);
void add_train(CLI::App& mien, int& code);
void add_remap(CLI::App& mien, int& code);
void add_evaluate(CLI::App& mien, int& code);
void add_live(CLI::App& mien, int& code);
void add_send(CLI::App& mien, int& code);

}  // namespace mien::tools
