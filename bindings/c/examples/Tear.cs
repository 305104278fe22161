// Tears the scene of a file and writes the torn sheet as OBJ: Tear SCENE.toml SHEET.obj
using System;
using System.Globalization;
using System.IO;
using Rhexis;
using static Rhexis.RhexisException;

public static class Tear
{
    static string Number(double value)
    {
        return value.ToString("R", CultureInfo.InvariantCulture);
    }

    static void WriteObj(RhexisWorld world, RhexisEntity body, string path)
    {
        Check(Native.rhexis_positions(world, body, out var positions));
        Check(Native.rhexis_indices(world, body, out var indices));
        var numbers = positions.ToArray();
        var rows = indices.ToArray();
        using (var file = new StreamWriter(path))
        {
            for (int i = 0; i < numbers.Length; i += 3)
            {
                file.WriteLine("v " + Number(numbers[i]) + " " + Number(numbers[i + 1]) + " " + Number(numbers[i + 2]));
            }
            for (int i = 0; i < rows.Length; i += 3)
            {
                file.WriteLine("f " + (rows[i] + 1) + " " + (rows[i + 1] + 1) + " " + (rows[i + 2] + 1));
            }
        }
    }

    static void Run(string scene, string sheet)
    {
        Check(Native.rhexis_check_abi(Native.RHEXIS_ABI_VERSION, 0));
        Check(Native.rhexis_world_from_scene(File.ReadAllText(scene), scene, out var world));
        var bodies = new RhexisEntity[1];
        Check(Native.rhexis_bodies(world, bodies, (UIntPtr)1, out _));
        RhexisReport report;
        byte isFinished;
        int advances = 0;
        do
        {
            Check(Native.rhexis_advance(world, out report));
            RhexisEvent happened;
            do
            {
                Check(Native.rhexis_next_event(world, out happened));
                if (happened.kind == Native.RHEXIS_EVENT_ADVANCED) { advances++; }
            }
            while (happened.kind != Native.RHEXIS_EVENT_NONE);
            Check(Native.rhexis_is_finished(world, out isFinished));
        }
        while (isFinished == 0);
        WriteObj(world, bodies[0], sheet);
        Check(Native.rhexis_hash(world, out var hash));
        Console.Error.WriteLine(advances + " advances in " + report.step + " steps");
        Console.WriteLine(hash.ToString("x16"));
        Check(Native.rhexis_world_destroy(world));
    }

    public static int Main(string[] arguments)
    {
        if (arguments.Length != 2)
        {
            Console.Error.WriteLine("Tear SCENE.toml SHEET.obj");
            return 2;
        }
        try
        {
            Run(arguments[0], arguments[1]);
            return 0;
        }
        catch (DllNotFoundException)
        {
            Console.Error.WriteLine("librhexis_c is not found: name its directory in LD_LIBRARY_PATH, on Windows in PATH");
            return 1;
        }
        catch (Exception error) when (error is RhexisException || error is IOException)
        {
            Console.Error.WriteLine(error.Message);
            return 1;
        }
    }
}
