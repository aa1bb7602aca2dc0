#include "exact/arithmetic.h"

#include "core/error.h"

namespace sightline {

void check_arithmetic() {
    // Read one by one, so that the compiler can neither fold nor share the products.
    volatile float x = 1 + 0x1p-12f, least = 0x1p-149f, half = 0.5f;
    const float a = x, b = x, c = x, d = x;
    if (a * b - c * d != 0)
        throw Error("this build fuses multiplications and additions; use -ffp-contract=off");
    if (least + least == least * half)
        throw Error("this thread flushes denormal numbers to zero, which breaks the exact tests");
}

}  // namespace sightline
