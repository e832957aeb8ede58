# A room is one folder, one library and one namespace. USES names the rooms and libraries its headers need (and so
# everything above it gets them too), PRIVATELY those only its sources need. Link visibility is the dependency
# diagram; tests/arrows.sh holds the #include lines against it.

function(mien_room name)
    cmake_parse_arguments(ROOM "" "" "USES;PRIVATELY;EXCLUDE" ${ARGN})
    file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
    foreach(file ${ROOM_EXCLUDE})
        list(REMOVE_ITEM sources ${CMAKE_CURRENT_SOURCE_DIR}/${file})
    endforeach()
    mien_library(${name} SOURCES ${sources} USES ${ROOM_USES} PRIVATELY ${ROOM_PRIVATELY})
endfunction()

# A library with its sources named: for a room that is two targets, as decoder and decoder_av are.
function(mien_library name)
    cmake_parse_arguments(LIB "" "" "SOURCES;USES;PRIVATELY" ${ARGN})
    if(LIB_SOURCES)
        add_library(mien_${name} STATIC ${LIB_SOURCES})
        set(kind PUBLIC)
    else()
        add_library(mien_${name} INTERFACE)
        set(kind INTERFACE)
    endif()
    add_library(mien::${name} ALIAS mien_${name})
    target_include_directories(mien_${name} ${kind} ${PROJECT_SOURCE_DIR})
    target_link_libraries(mien_${name} ${kind} ${LIB_USES})
    if(LIB_SOURCES)
        target_link_libraries(mien_${name} PRIVATE ${LIB_PRIVATELY})
    endif()
endfunction()

# One test program per room from all *_test.cpp of the calling folder.
function(mien_test name)
    cmake_parse_arguments(TEST "" "TIMEOUT" "USES" ${ARGN})
    file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
    if(NOT sources)
        return()
    endif()
    add_executable(test_${name} ${sources})
    target_link_libraries(test_${name} PRIVATE ${TEST_USES} GTest::gtest GTest::gtest_main)
    target_include_directories(test_${name} PRIVATE ${PROJECT_SOURCE_DIR})
    target_compile_definitions(test_${name} PRIVATE
        MIEN_SOURCE_DIR="${PROJECT_SOURCE_DIR}" MIEN_BINARY_DIR="${CMAKE_RUNTIME_OUTPUT_DIRECTORY}")
    add_test(NAME ${name} COMMAND test_${name})
    if(NOT TEST_TIMEOUT)
        set(TEST_TIMEOUT 600)
        if(MIEN_SANITIZE STREQUAL "thread")
            set(TEST_TIMEOUT 1800)   # it takes tens of times as long
        endif()
    endif()
    set_tests_properties(${name} PROPERTIES TIMEOUT ${TEST_TIMEOUT})
endfunction()
