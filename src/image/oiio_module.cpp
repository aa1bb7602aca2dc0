extern "C" int sightline_oiio_placeholder() { return 0; }
