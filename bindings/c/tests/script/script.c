/* Plays the script on the scene of a file and prints the hash at the end: script SCENE.toml */
#include "rhexis.h"

#include <stdio.h>
#include <stdlib.h>

static void check(RhexisStatus status) {
    if (status != RHEXIS_STATUS_OK) {
        fprintf(stderr, "%s: %s\n", rhexis_status_name(status), rhexis_last_error_message());
        exit(1);
    }
}

int main(int argc, char **argv) {
    static char scene[1 << 16];
    static const double line[6] = {3, 0, 0, 3, 2, 0};
    static const RhexisVec3 aside = {-0.01, 0, 0};
    RhexisWorld world;
    RhexisEntity body, forceps;
    RhexisViewU64 keys;
    RhexisJaws jaws;
    RhexisPose pose;
    RhexisGrasp grasp;
    RhexisEvent event;
    uint8_t is_finished = 0;
    uint64_t pinned[3], hash = 0;
    unsigned advances = 0;
    FILE *file = argc == 2 ? fopen(argv[1], "rb") : NULL;

    if (file == NULL || fread(scene, 1, sizeof scene - 1, file) == 0) {
        fprintf(stderr, "script SCENE.toml\n");
        return 2;
    }
    fclose(file);
    check(rhexis_check_abi(RHEXIS_ABI_VERSION, 0));
    check(rhexis_world_from_scene(scene, argv[1], &world));
    check(rhexis_find_body(world, "sheet", &body));
    check(rhexis_vertex_keys(world, body, &keys));
    pinned[0] = keys.data[0];
    pinned[1] = keys.data[7];
    pinned[2] = keys.data[14];
    check(rhexis_pin(world, body, "left", pinned, 3));
    check(rhexis_cut(world, body, line, 2, NULL));
    check(rhexis_jaws_init(&jaws));
    check(rhexis_pose_init(&pose));
    check(rhexis_grasp_init(&grasp));
    jaws.stiffness = 0.2;
    pose.position.x = 5;
    pose.position.y = 1;
    pose.position.z = 0.3;
    check(rhexis_forceps_create(world, "forceps", &jaws, &pose, &forceps));
    check(rhexis_forceps_close(world, forceps, body, &grasp, NULL));
    for (int step = 1; !is_finished; step++) {
        pose.position.x = 5 + 0.05 * step;
        pose.position.z = 0.3 + 0.05 * step;
        check(rhexis_forceps_move(world, forceps, &pose, 5));
        check(rhexis_pins_shift(world, body, "left", aside));
        check(rhexis_advance(world, NULL));
        do {
            check(rhexis_next_event(world, &event));
            advances += event.kind == RHEXIS_EVENT_ADVANCED;
        } while (event.kind != RHEXIS_EVENT_NONE);
        check(rhexis_is_finished(world, &is_finished));
    }
    check(rhexis_hash(world, &hash));
    printf("%016llx %u\n", (unsigned long long)hash, advances);
    check(rhexis_world_destroy(world));
    return 0;
}
