#include "render/film.h"

namespace sightline {

const Channel* Film::find(const std::string& name) const {
    for (const Channel& channel : channels) {
        if (channel.name == name) return &channel;
    }
    return nullptr;
}

}  // namespace sightline
