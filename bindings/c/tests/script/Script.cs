// Plays the script on the scene of a file and prints the hash at the end: Script SCENE.toml
//
// It also holds what crosses the boundary in other forms than numbers: texts, arrays within structures, null for a buffer, a refusal.
using System;
using System.IO;
using System.Runtime.InteropServices;
using System.Text;
using Rhexis;
using static Rhexis.RhexisException;

public static class Script
{
    static RhexisVec3 At(double x, double y, double z)
    {
        return new RhexisVec3 { x = x, y = y, z = z };
    }

    static void Hold(bool fact, string what)
    {
        if (!fact) { throw new InvalidOperationException(what); }
    }

    static void HoldForms(RhexisWorld world, RhexisEntity body)
    {
        Check(Native.rhexis_build_info(out var info));
        Hold(info.abi_version == Native.RHEXIS_ABI_VERSION && info.pointer_bits == 8 * IntPtr.Size, "build info");
        Hold(Marshal.PtrToStringUTF8(info.version).Split('.').Length == 3, "version");

        var status = Native.rhexis_get(world, body, "Tearing", null, UIntPtr.Zero, out var count);
        Hold(status == RhexisStatus.BufferTooSmall && (int)count > 20, "count of a text");
        var buffer = new byte[(int)count];
        Check(Native.rhexis_get(world, body, "Tearing", buffer, count, out count));
        Hold(Encoding.UTF8.GetString(buffer).Contains("radius = 1.5"), "text of a component");

        Check(Native.rhexis_nearest(world, body, At(0.2, 0.1, 5), 10, out var hit));
        Hold(hit.corners.Length == 3 && hit.weights.Length == 3, "arrays of a hit");
        Hold(Math.Abs(hit.weights[0] + hit.weights[1] + hit.weights[2] - 1) < 1e-12, "weights");
        var off = Math.Abs(hit.rest_position.x - 0.2) + Math.Abs(hit.rest_position.y - 0.1) + Math.Abs(hit.distance - 5);
        Hold(off < 1e-12 && hit.normal.z == 1, "place of a hit");

        status = Native.rhexis_set(world, body, "Tearing", "radius = -1");
        try
        {
            Check(status);
            Hold(false, "a negative radius is taken");
        }
        catch (RhexisException error)
        {
            Hold(error.Status == status && error.Message.Contains("radius"), "message: " + error.Message);
        }
    }

    static void Play(string path)
    {
        Check(Native.rhexis_check_abi(Native.RHEXIS_ABI_VERSION, 0));
        Check(Native.rhexis_world_from_scene(File.ReadAllText(path), path, out var world));
        Check(Native.rhexis_find_body(world, "sheet", out var body));
        HoldForms(world, body);
        Check(Native.rhexis_vertex_keys(world, body, out var keys));
        var pinned = new ulong[3];
        for (int i = 0; i < 3; i++) { pinned[i] = (ulong)Marshal.ReadInt64(keys.data, 7 * 8 * i); }
        Check(Native.rhexis_pin(world, body, "left", pinned, (UIntPtr)3));
        Check(Native.rhexis_cut(world, body, new double[] { 3, 0, 0, 3, 2, 0 }, (UIntPtr)2, out _));
        Check(Native.rhexis_jaws_init(out var jaws));
        Check(Native.rhexis_pose_init(out var pose));
        Check(Native.rhexis_grasp_init(out var grasp));
        jaws.stiffness = 0.2;
        pose.position = At(5, 1, 0.3);
        Check(Native.rhexis_forceps_create(world, "forceps", ref jaws, ref pose, out var forceps));
        Check(Native.rhexis_forceps_close(world, forceps, body, ref grasp, out _));
        int advances = 0;
        byte isFinished = 0;
        for (int step = 1; isFinished == 0; step++)
        {
            pose.position = At(5 + 0.05 * step, 1, 0.3 + 0.05 * step);
            Check(Native.rhexis_forceps_move(world, forceps, ref pose, 5));
            Check(Native.rhexis_pins_shift(world, body, "left", At(-0.01, 0, 0)));
            Check(Native.rhexis_advance(world, out _));
            RhexisEvent happened;
            do
            {
                Check(Native.rhexis_next_event(world, out happened));
                if (happened.kind == Native.RHEXIS_EVENT_ADVANCED) { advances++; }
            }
            while (happened.kind != Native.RHEXIS_EVENT_NONE);
            Check(Native.rhexis_is_finished(world, out isFinished));
        }
        Check(Native.rhexis_hash(world, out var hash));
        Console.WriteLine(hash.ToString("x16") + " " + advances);
        Check(Native.rhexis_world_destroy(world));
    }

    public static int Main(string[] arguments)
    {
        if (arguments.Length != 1)
        {
            Console.Error.WriteLine("Script SCENE.toml");
            return 2;
        }
        Play(arguments[0]);
        return 0;
    }
}
