#pragma once

#include <stdexcept>

namespace mien {

/// The environment fails us: no such folder to write to, no OpenGL, a full disk. The message tells the user what to do.
class EnvironmentError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

}  // namespace mien
