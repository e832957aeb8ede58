# Every library the project uses, found once. docs/architecture.md says which room may use which.

find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)
find_package(fmt REQUIRED)
pkg_check_modules(EIGEN REQUIRED IMPORTED_TARGET eigen3)
pkg_check_modules(ZSTD REQUIRED IMPORTED_TARGET libzstd)
find_package(OpenSSL REQUIRED COMPONENTS Crypto)

if(NOT MIEN_CORE_ONLY)
    pkg_check_modules(FFMPEG REQUIRED IMPORTED_TARGET libavcodec libavformat libavutil libswscale libswresample)
    pkg_check_modules(EPOXY REQUIRED IMPORTED_TARGET epoxy)
    pkg_check_modules(EGL REQUIRED IMPORTED_TARGET egl)
    pkg_check_modules(GLFW REQUIRED IMPORTED_TARGET glfw3)
    pkg_check_modules(IMGUI REQUIRED IMPORTED_TARGET imgui)
    pkg_check_modules(OPENAL REQUIRED IMPORTED_TARGET openal)
    pkg_check_modules(SNDFILE REQUIRED IMPORTED_TARGET sndfile)
    find_package(nlohmann_json REQUIRED)
    find_package(CLI11 REQUIRED)
    find_path(ASIO_INCLUDE asio.hpp REQUIRED)
    find_path(STB_INCLUDE stb_image.h PATH_SUFFIXES stb REQUIRED)

    add_library(asio INTERFACE)
    target_include_directories(asio SYSTEM INTERFACE ${ASIO_INCLUDE})
    # Asio finds aligned_alloc only when a standard header comes before it; files that differ in that would not link soundly.
    target_compile_definitions(asio INTERFACE ASIO_STANDALONE ASIO_NO_DEPRECATED ASIO_DISABLE_STD_ALIGNED_ALLOC)
    target_link_libraries(asio INTERFACE Threads::Threads)
    add_library(stb INTERFACE)
    target_include_directories(stb SYSTEM INTERFACE ${STB_INCLUDE})

    if(MIEN_SPEECH)
        pkg_check_modules(ESPEAK IMPORTED_TARGET espeak-ng)
    endif()
endif()

if(MIEN_TESTS)
    find_package(GTest REQUIRED)
endif()
