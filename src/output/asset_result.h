#pragma once
// What an asset's picture has cost, and what there is to say of it.
#include "output/data_layers.h"
#include "output/picture_check.h"
#include "output/poses.h"

namespace sightline {

/// Wall-clock seconds of each stage. What pictures share costs the first of them alone.
struct StageTimes {
    double open = 0;     ///< reading the glTF file
    double parse = 0;    ///< its JSON and geometry, and its buffers
    double pose = 0;     ///< taking the scene to another time than that of the picture before
    double decode = 0;   ///< images, and the environment where that takes longer
    double build = 0;    ///< the acceleration structure
    double prepare = 0;  ///< pyramids of textures, emitters, faces that let light through
    double trace = 0;    ///< rays through the structure: the threads' share of `render`
    double shade = 0;    ///< the rest of `render`
    double render = 0;   ///< with the compression of EXRs, which runs in parallel
    double write = 0;    ///< the rest of the outputs
    double total = 0;

    double load() const { return open + parse + pose + decode; }

    void add(const StageTimes& more);
};

/// Bytes that the stages have read and made.
struct StageBytes {
    size_t files = 0;         ///< read: glTF, buffers, images; 0 if they were in memory
    size_t images = 0;        ///< of the decoded levels
    size_t whole_images = 0;  ///< the same if level 0 of each were kept
    size_t pyramids = 0;      ///< the levels made of them
};

/// A finished asset.
struct AssetResult {
    RenderResult picture;
    Needs needs;
    StageTimes seconds;
    StageBytes bytes;
    uint64_t finer_lookups = 0;  ///< in textures: of levels that were not kept
    std::vector<std::string> warnings;
    std::vector<FoundFault> faults;  ///< of the file, as in Scene
    uint64_t fault_count = 0;
    std::vector<SourceFile> inputs;  ///< every file that was read, the environment last
    std::string intersector;
    size_t scene_bytes = 0, intersector_bytes = 0;
    unsigned threads = 0;
    bool interrupted = false;
    /// Of a whole picture. If it shows nothing, the last warning says why.
    PictureContent content = PictureContent::something;
    CameraPose pose;
    std::map<std::string, DataScale> data_scales;  ///< by layer of OutputOptions::data
    Image preview;  ///< with OutputOptions::preview: the beauty layer as an 8-bit RGB picture
};

}  // namespace sightline
