// Run-time dispatch over instruction sets for hot loops: the default build runs on any x86-64,
// and functions marked KINEMESH_MULTIVERSION are compiled for wider vectors too.
#pragma once

// Sanitizers instrument code that runs before their own start-up when ifunc resolvers call it.
#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__)
#define KINEMESH_MULTIVERSION __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define KINEMESH_MULTIVERSION
#endif
