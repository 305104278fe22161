/* Tears the scene of a file and writes the torn sheet as OBJ: tear SCENE.toml SHEET.obj */
#include "rhexis.h"

#include <stdio.h>
#include <stdlib.h>

static void check(RhexisStatus status) {
    if (status != RHEXIS_STATUS_OK) {
        fprintf(stderr, "%s: %s\n", rhexis_status_name(status), rhexis_last_error_message());
        exit(1);
    }
}

static char *text_of(const char *path) {
    FILE *file = fopen(path, "rb");
    char *text = NULL;
    long size = -1;
    if (file != NULL && fseek(file, 0, SEEK_END) == 0) {
        size = ftell(file);
        rewind(file);
    }
    if (size >= 0) {
        text = malloc((size_t)size + 1);
    }
    if (text == NULL || fread(text, 1, (size_t)size, file) != (size_t)size) {
        fprintf(stderr, "%s cannot be read\n", path);
        exit(1);
    }
    fclose(file);
    text[size] = '\0';
    return text;
}

static void write_obj(RhexisWorld world, RhexisEntity body, const char *path) {
    RhexisViewF64 positions;
    RhexisViewU32 indices;
    FILE *file = fopen(path, "w");
    if (file == NULL) {
        fprintf(stderr, "%s cannot be written\n", path);
        exit(1);
    }
    check(rhexis_positions(world, body, &positions));
    check(rhexis_indices(world, body, &indices));
    for (size_t i = 0; i + 2 < positions.count; i += 3) {
        fprintf(file, "v %.17g %.17g %.17g\n", positions.data[i], positions.data[i + 1], positions.data[i + 2]);
    }
    for (size_t i = 0; i + 2 < indices.count; i += 3) {
        fprintf(file, "f %u %u %u\n", (unsigned)(indices.data[i] + 1), (unsigned)(indices.data[i + 1] + 1),
                (unsigned)(indices.data[i + 2] + 1));
    }
    fclose(file);
}

int main(int argc, char **argv) {
    RhexisWorld world;
    RhexisEntity body;
    RhexisReport report = {0};
    uint8_t is_finished = 0;
    uint64_t hash = 0;
    unsigned advances = 0;
    size_t count = 0;
    char *scene;

    if (argc != 3) {
        fprintf(stderr, "tear SCENE.toml SHEET.obj\n");
        return 2;
    }
    check(rhexis_check_abi(RHEXIS_ABI_VERSION, 0));
    scene = text_of(argv[1]);
    check(rhexis_world_from_scene(scene, argv[1], &world));
    free(scene);
    check(rhexis_bodies(world, &body, 1, &count));

    while (!is_finished) {
        RhexisEvent event;
        check(rhexis_advance(world, &report));
        for (;;) {
            check(rhexis_next_event(world, &event));
            if (event.kind == RHEXIS_EVENT_NONE) {
                break;
            }
            advances += event.kind == RHEXIS_EVENT_ADVANCED;
            if (event.kind == RHEXIS_EVENT_ENDED) {
                fprintf(stderr, "torn through at (%g, %g) mm, %g ms\n", event.at.x, event.at.y, event.time);
            }
        }
        check(rhexis_is_finished(world, &is_finished));
    }
    write_obj(world, body, argv[2]);
    check(rhexis_hash(world, &hash));
    fprintf(stderr, "%u advances in %u steps\n", advances, (unsigned)report.step);
    printf("%016llx\n", (unsigned long long)hash);
    check(rhexis_world_destroy(world));
    return 0;
}
