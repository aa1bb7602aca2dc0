// A libFuzzer target for decode_jpeg: tools/fuzz jpeg SECONDS.
#include "fuzz/decode_image.h"
#include "image/jpeg.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    sightline::decode_input(data, size, sightline::decode_jpeg);
    return 0;
}
