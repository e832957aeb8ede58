# Compiler, linker and sanitizer settings that hold for every target.

find_program(CCACHE ccache)
if(CCACHE)
    set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE})
    set(CMAKE_C_COMPILER_LAUNCHER ${CCACHE})
endif()
find_program(MOLD mold)
if(MOLD)
    add_link_options(-fuse-ld=mold)
endif()

add_compile_options(-Wall -Wextra -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual -Wno-missing-field-initializers)
if(MIEN_WERROR)
    add_compile_options(-Werror)
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # GCC 12 reports maybe-uninitialized and array-bounds inside Eigen and libstdc++ when sanitizers are on.
    add_compile_options(-Wno-maybe-uninitialized -Wno-array-bounds -Wno-stringop-overflow -Wno-psabi)
    if(CMAKE_BUILD_TYPE STREQUAL "Release")
        # GCC 12 sees overlapping copies in string concatenation at -O3 (its bug 105651).
        add_compile_options(-Wno-restrict)
    endif()
endif()

# The same float results on every build of one source: no contraction behind our back. Fast paths ask for FMA by name.
add_compile_options(-ffp-contract=off)

if(MIEN_SANITIZE)
    add_compile_options(-fsanitize=${MIEN_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
    add_link_options(-fsanitize=${MIEN_SANITIZE})
endif()
if(MIEN_FUZZ)
    add_compile_options(-fsanitize=fuzzer-no-link)
endif()
