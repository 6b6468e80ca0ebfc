# Compiler settings shared by every target.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
# Half the time of a small source goes into headers. Names in unnamed namespaces are therefore unique
# within a module.
set(CMAKE_UNITY_BUILD ${KINEMESH_UNITY})
set(CMAKE_UNITY_BUILD_BATCH_SIZE 6)

add_library(kinemesh_compiler INTERFACE)
# No contraction to fused multiply-add: the code paths chosen at run time must give the same bytes.
target_compile_options(kinemesh_compiler INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual -Werror
  -Wno-missing-field-initializers -ffp-contract=off
  -Wno-restrict)  # gcc 12 reports false ones in std::string (GCC bug 105651)
if(CMAKE_CXX_COMPILER_ID MATCHES "Clang")  # the fuzz preset; warnings are judged by gcc
  target_compile_options(kinemesh_compiler INTERFACE -Wno-error -Wno-unknown-warning-option)
endif()
if(KINEMESH_FUZZ)
  target_compile_options(kinemesh_compiler INTERFACE -fsanitize=fuzzer-no-link)
  target_link_options(kinemesh_compiler INTERFACE -fsanitize=fuzzer-no-link)
endif()
if(KINEMESH_SANITIZE)
  target_compile_options(kinemesh_compiler INTERFACE
    -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer
    # Checked at every dereference, these double the time to compile; the address sanitizer finds the
    # null pointers and the objects that are too small when they are used.
    -fno-sanitize=null,alignment,object-size,vptr
    -Wno-maybe-uninitialized)  # gcc 12 reports false ones under the sanitizers
  target_link_options(kinemesh_compiler INTERFACE -fsanitize=address,undefined)
endif()
