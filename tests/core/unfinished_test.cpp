#include "core/unfinished.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <optional>

#include "core/environment_error.hpp"
#include "core/interruption.hpp"
#include "tests/temporary_folder.hpp"

namespace mien {
namespace {

namespace fs = std::filesystem;
using tests::TemporaryFolder;

void write(const fs::path& path, const char* text) { std::ofstream(path) << text; }
std::string read(const fs::path& path) {
    std::string text;
    std::getline(std::ifstream(path), text);
    return text;
}

TEST(Unfinished, HasANameOfItsOwnUntilItIsGivenTheTargets) {
    const TemporaryFolder folder;
    write(folder / "a.part", "somebody else's");
    Unfinished first(folder / "a", Unfinished::Kind::file);
    std::optional<Unfinished> second(std::in_place, folder / "a", Unfinished::Kind::file);
    EXPECT_NE(first.path(), second->path());
    write(first.path(), "first");
    write(second->path(), "second");
    EXPECT_FALSE(second->finish(false));
    EXPECT_EQ(first.finish(false), std::errc::file_exists);
    EXPECT_EQ(read(folder / "a"), "second");
    EXPECT_FALSE(first.finish(true));
    second.reset();
    EXPECT_EQ(read(folder / "a"), "first");
    EXPECT_EQ(read(folder / "a.part"), "somebody else's");
    EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()), 2);
}

TEST(Unfinished, IsGoneWithItsObjectAndSaysWhyItCannotBe) {
    const TemporaryFolder folder;
    { const Unfinished file(folder / "a", Unfinished::Kind::file), made(folder / "b", Unfinished::Kind::folder); }
    EXPECT_TRUE(fs::is_empty(folder.path()));
    try {
        const Unfinished nowhere(folder / "none" / "a", Unfinished::Kind::file);
        FAIL();
    } catch (const EnvironmentError& error) {
        EXPECT_NE(std::string(error.what()).find("make the folder first"), std::string::npos) << error.what();
    }
}

/// Runs `work` in a process of its own, sends it `signal` when it is ready, and returns what waitpid tells.
template <class Work>
int interrupted(int signal, int times, Work work) {
    int ready[2];
    EXPECT_EQ(::pipe(ready), 0);
    const pid_t child = ::fork();
    if (child == 0) {
        end_in_order([&] { EXPECT_EQ(::write(ready[1], "s", 1), 1); });
        work(ready[1]);
        _exit(3);
    }
    char byte = 0;
    for (int n = 0; n < times; ++n) {
        EXPECT_EQ(::read(ready[0], &byte, 1), 1);
        ::kill(child, signal);
    }
    int status = 0;
    EXPECT_EQ(::waitpid(child, &status, 0), child);
    ::close(ready[0]);
    ::close(ready[1]);
    return status;
}

TEST(Interruption, LeavesNothingUnfinishedAndEndsByItsSignal) {
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
        const TemporaryFolder folder;
        const int status = interrupted(signal, 1, [&](int ready) {
            const Unfinished file(folder / "a", Unfinished::Kind::file), made(folder / "b", Unfinished::Kind::folder);
            const Unfinished nested(made.path() / "c", Unfinished::Kind::file);
            if (::write(ready, "r", 1) != 1) _exit(4);
            // As a writer does that is in the middle of its work.
            for (int n = 0;; ++n) write(made.path() / std::to_string(n % 1000), "frame");
        });
        EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == signal) << status;
        EXPECT_TRUE(fs::is_empty(folder.path()));
    }
}

TEST(Interruption, MayBeAskedToWaitOnce) {
    const int once = interrupted(SIGTERM, 1, [&](int ready) {
        const StopRequest stop;
        if (stop.asked() || ::write(ready, "r", 1) != 1) _exit(4);
        while (!stop.asked()) ::usleep(1000);
        _exit(0);
    });
    EXPECT_TRUE(WIFEXITED(once) && WEXITSTATUS(once) == 0) << once;
    const int twice = interrupted(SIGTERM, 2, [&](int ready) {
        const StopRequest stop;
        if (::write(ready, "r", 1) != 1) _exit(4);
        while (!stop.asked()) ::usleep(1000);
        if (::write(ready, "r", 1) != 1) _exit(4);
        for (;;) ::pause();
    });
    EXPECT_TRUE(WIFSIGNALED(twice) && WTERMSIG(twice) == SIGTERM) << twice;
}

TEST(Interruption, IsNotWhatIsIgnored) {
    const pid_t child = ::fork();
    if (child == 0) {
        ::signal(SIGHUP, SIG_IGN);   // as nohup does
        ::signal(SIGINT, SIG_IGN);   // as the background of a script does
        end_in_order([] {});
        for (const int signal : {SIGHUP, SIGINT}) ::kill(::getpid(), signal);
        ::usleep(20'000);
        const StopRequest stop;
        ::kill(::getpid(), SIGINT);
        for (int n = 0; n < 1000 && !stop.asked(); ++n) ::usleep(1000);
        _exit(stop.asked() ? 0 : 5);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
}

}  // namespace
}  // namespace mien
