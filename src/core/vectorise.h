#pragma once
// Plain loops compiled for several instruction sets; the best is chosen at run time. As the
// compiler never contracts operations here, all versions give the same bits.

namespace sightline {

namespace vectorised {
template <auto loop, class... Arguments>
void anywhere(Arguments... arguments) {
    loop(arguments...);
}
#if defined(__x86_64__)
template <auto loop, class... Arguments>
[[gnu::target("avx2")]] void avx2(Arguments... arguments) {
    loop(arguments...);
}
template <auto loop, class... Arguments>
[[gnu::target("avx512f,avx512dq,avx512vl,avx512bw")]] void avx512(Arguments... arguments) {
    loop(arguments...);
}
#endif
}  // namespace vectorised

/// The version of `loop`, a [[gnu::always_inline]] function, for this processor. The compiler
/// vectorises its loops only if they contain neither branches nor calls.
template <auto loop, class... Arguments>
auto best_version() -> void (*)(Arguments...) {
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") &&
        __builtin_cpu_supports("avx512bw"))
        return vectorised::avx512<loop, Arguments...>;
    if (__builtin_cpu_supports("avx2")) return vectorised::avx2<loop, Arguments...>;
#endif
    return vectorised::anywhere<loop, Arguments...>;
}

}  // namespace sightline
