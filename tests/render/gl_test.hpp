#pragma once

#include <gtest/gtest.h>

#include <optional>

#include "core/environment_error.hpp"
#include "render/context.hpp"

namespace mien::render {

/// Tests that need OpenGL 4.5; skipped where there is none.
class GLTest : public testing::Test {
protected:
    void SetUp() override {
        try {
            context_.emplace();
        } catch (const EnvironmentError& error) {
            GTEST_SKIP() << "skipped: " << error.what();
        }
    }

private:
    std::optional<OffscreenContext> context_;
};

}  // namespace mien::render
