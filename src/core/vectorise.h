#pragma once
// Plain loops compiled for several processors, the best chosen at run time. Nothing contracts
// operations in this project, so all give the same bits.

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

/// The version of `loop`, a function that is [[gnu::always_inline]], for this processor. To be
/// turned into vector code its loops must hold no branch and no call.
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
