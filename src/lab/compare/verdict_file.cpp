#include "lab/compare/verdict_file.h"

#include "core/binary_file.h"

namespace sightline {

void write_verdicts(const std::string& path, const Comparison& comparison, uint64_t geometry_hash,
                    uint64_t rays_hash) {
    write_binary_file(path, "the verdicts", [&](std::ostream& file) {
        const auto& all = comparison.verdicts;
        file << "SLVERD1\n";
        put(file, uint64_t{all.empty() ? 0 : all[0].size()});
        put(file, geometry_hash);
        put(file, rays_hash);
        put(file, uint64_t{all.size()});
        for (size_t e = 0; e < all.size(); ++e) {
            const std::string& name = comparison.engines[e].name;
            put(file, uint64_t{name.size()});
            file << name;
            file.write(reinterpret_cast<const char*>(all[e].data()),
                       static_cast<std::streamsize>(all[e].size()));
        }
    });
}

}  // namespace sightline
