// Four doubles at a time, on machines that have registers of that size. Each of the four is computed by
// the operations of one double in their order, and no operations are fused: results are bitwise identical.
#pragma once

namespace freeplay {

/// Marks a function that is called only if has_wide_registers.
#ifdef __x86_64__
#define FREEPLAY_WIDE [[gnu::target("avx2")]]
inline const bool has_wide_registers = __builtin_cpu_supports("avx2") != 0;
#else
#define FREEPLAY_WIDE
inline constexpr bool has_wide_registers = false;
#endif

}  // namespace freeplay
