// Tears the scene of a file and writes the torn sheet as OBJ: tear SCENE.toml SHEET.obj
#include "rhexis.hpp"

#include <cstdio>
#include <exception>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <string>

namespace {

std::string text_of(const char *path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) {
        throw std::runtime_error(std::string(path) + " cannot be read");
    }
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
}

void write_obj(const rhexis::Body &sheet, const char *path) {
    std::ofstream file(path);
    file << std::setprecision(17);
    const auto positions = sheet.positions();
    for (std::size_t i = 0; i + 2 < positions.size(); i += 3) {
        file << "v " << positions[i] << ' ' << positions[i + 1] << ' ' << positions[i + 2] << '\n';
    }
    const auto rows = sheet.indices();
    for (std::size_t i = 0; i + 2 < rows.size(); i += 3) {
        file << "f " << rows[i] + 1 << ' ' << rows[i + 1] + 1 << ' ' << rows[i + 2] + 1 << '\n';
    }
}

} // namespace

int main(int argc, char **argv) {
    if (argc != 3) {
        std::cerr << "tear SCENE.toml SHEET.obj\n";
        return 2;
    }
    try {
        rhexis::check_abi();
        auto world = rhexis::World::from_scene(text_of(argv[1]), argv[1]);
        const rhexis::Body sheet = world.bodies().at(0);
        RhexisReport report{};
        unsigned advances = 0;
        while (!world.is_finished()) {
            report = world.advance();
            while (const auto event = world.next_event()) {
                advances += event->kind == RHEXIS_EVENT_ADVANCED ? 1u : 0u;
            }
        }
        write_obj(sheet, argv[2]);
        std::cerr << advances << " advances in " << report.step << " steps\n";
        std::printf("%016llx\n", static_cast<unsigned long long>(world.hash()));
    } catch (const std::exception &error) {
        std::cerr << error.what() << '\n';
        return 1;
    }
    return 0;
}
