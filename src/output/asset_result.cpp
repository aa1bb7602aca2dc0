#include "output/asset_result.h"

namespace sightline {

void StageTimes::add(const StageTimes& more) {
    for (double StageTimes::*stage :
         {&StageTimes::open, &StageTimes::parse, &StageTimes::pose, &StageTimes::decode,
          &StageTimes::build, &StageTimes::prepare, &StageTimes::trace, &StageTimes::shade,
          &StageTimes::render, &StageTimes::write, &StageTimes::total})
        this->*stage += more.*stage;
}

}  // namespace sightline
