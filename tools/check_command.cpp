#include <fmt/core.h>

#include "io/clip_check.hpp"
#include "tools/commands.hpp"
#include "tools/console.hpp"

namespace mien::tools {

void add_check(CLI::App& mien, int& code) {
    auto clip = std::make_shared<std::string>();
    auto json = std::make_shared<bool>(false);
    CLI::App* command = mien.add_subcommand("check", "List what is in a clip and every inconsistency, by name and frame");
    command->add_option("clip", *clip, "Clip folder, folder of numbered OBJs, or a single recording")->required();
    command->add_flag("--json", *json, "As JSON");
    command->callback([clip, json, &code] {
        code = guarded([&]() -> Result<int> {
            const io::ClipReport report = io::check_clip(*clip, progress_bar(*json));
            end_progress();
            fmt::print("{}", *json ? report.json() + "\n" : report.text());
            return report.good() ? kDone : kFailed;
        }, *json);
    });
}

}  // namespace mien::tools
