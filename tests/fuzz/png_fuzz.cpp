// A libFuzzer target for decode_png: tools/fuzz png SECONDS.
#include "fuzz/decode_image.h"
#include "image/png.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    sightline::decode_input(data, size, sightline::decode_png);
    return 0;
}
