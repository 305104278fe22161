// Rhexis for C#: Unity and .NET. The declarations are those of rhexis.h; a test of the library compares names, arguments, types and fields.
//
// Units are mm, g, ms, hence N and MPa. One world is used by one thread at a time. What a view points at is borrowed until the next call that
// changes the world: copy it, as RhexisView.ToArray does.
using System;
using System.Runtime.InteropServices;

namespace Rhexis
{
    /// <summary>The answer of a call.</summary>
    public enum RhexisStatus : int
    {
        /// <summary>Done.</summary>
        Ok = 0,
        /// <summary>A null or misaligned pointer, text that is not UTF-8, a number out of its range.</summary>
        InvalidArgument = 1,
        /// <summary>A handle that was never given out, is destroyed, or belongs to another world or another kind of object.</summary>
        InvalidHandle = 2,
        /// <summary>Another thread is in a call with the same object; nothing was done. Call again later.</summary>
        Busy = 3,
        /// <summary>The buffer is too small; the number of elements needed has been written, and nothing else.</summary>
        BufferTooSmall = 4,
        /// <summary>The engine refused it; everything is as it was.</summary>
        Refused = 5,
        /// <summary>A scene, a component or settings in TOML that cannot be read; the message has line, reason and remedy.</summary>
        Scene = 6,
        /// <summary>Header and library are of different versions, or the library lacks a feature.</summary>
        AbiMismatch = 7,
        /// <summary>The library has failed inside; the world of the call is marked, and refuses further calls.</summary>
        Panic = 8,
        /// <summary>The world has failed in an earlier call. Destroy it; a snapshot from before can go on in a new one.</summary>
        Poisoned = 9,
        /// <summary>No more handles of this kind can be given out.</summary>
        Capacity = 10,
        /// <summary>There is no such thing: no tissue within reach, no body or component of this name, no model yet.</summary>
        NotFound = 11,
    }

    /// <summary>How the library was built.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct RhexisBuildInfo
    {
        /// <summary>`RHEXIS_ABI_VERSION` of the library.</summary>
        public uint abi_version;
        /// <summary>Bits of a pointer.</summary>
        public uint pointer_bits;
        /// <summary>Feature bits.</summary>
        public ulong features;
        /// <summary>Version of the engine, such as "0.1.0". Valid for ever.</summary>
        public IntPtr version;
        /// <summary>Not 0: assertions of a debug build are on.</summary>
        public byte is_debug;
    }

    /// <summary>A point, a direction or a force.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct RhexisVec3
    {
        /// <summary>Along x.</summary>
        public double x;
        /// <summary>Along y.</summary>
        public double y;
        /// <summary>Along z.</summary>
        public double z;
    }

    /// <summary>A body from arrays; start from `rhexis_body_init`.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct RhexisBodyDesc
    {
        /// <summary>Its name; NULL for "body".</summary>
        public IntPtr name;
        /// <summary>Rest positions [mm], three numbers per vertex.</summary>
        public IntPtr positions;
        /// <summary>Number of vertices.</summary>
        public UIntPtr vertex_count;
        /// <summary>Rows of the corners, three per triangle, counter-clockwise seen from outside.</summary>
        public IntPtr triangles;
        /// <summary>Number of triangles.</summary>
        public UIntPtr triangle_count;
        /// <summary>Fibre directions, three numbers per triangle, not zero; NULL for `fibre`.</summary>
        public IntPtr fibres;
        /// <summary>Fibre direction everywhere, where `fibres` is NULL.</summary>
        public RhexisVec3 fibre;
        /// <summary>Young's modulus along the fibres [MPa], &gt; 0.</summary>
        public double young_fibre;
        /// <summary>Young's modulus across the fibres [MPa], &gt; 0.</summary>
        public double young_transverse;
        /// <summary>Poisson's ratio: strain across from stress along the fibres.</summary>
        public double poisson_major;
        /// <summary>In-plane shear modulus [MPa]; 0 for Huber's from the others.</summary>
        public double shear_modulus;
        /// <summary>Thickness [mm], &gt; 0.</summary>
        public double thickness;
        /// <summary>Density [g/mm³], &gt; 0.</summary>
        public double density;
        /// <summary>Not 0: the body stays in its plane z = const.</summary>
        public byte planar;
    }

    /// <summary>Handle of a world. All bits zero: none.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct RhexisWorld
    {
        /// <summary>Kind and serial number.</summary>
        public ulong bits;
    }

    /// <summary>Handle of a body, an obstacle or a tool of one world. All bits zero: none.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct RhexisEntity
    {
        /// <summary>Tag of the world, generation, index.</summary>
        public ulong bits;
    }

    /// <summary>
    /// Something that has happened. Which fields are used depends on the kind; the others are zero. Places are in the rest shape.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct RhexisEvent
    {
        /// <summary>One of `RHEXIS_EVENT_STARTED` and the others; `RHEXIS_EVENT_NONE` where there are no more.</summary>
        public uint kind;
        /// <summary>1 where the criterion's margin is so small that another run could have gone the other way.</summary>
        public byte is_ambiguous;
        /// <summary>Step in which it happened.</summary>
        public ulong step;
        /// <summary>Time at the end of that step [ms].</summary>
        public double time;
        /// <summary>The body.</summary>
        public RhexisEntity body;
        /// <summary>Key of the tip; 0 for none.</summary>
        public ulong tip;
        /// <summary>Where [mm]: of an advance, from where.</summary>
        public RhexisVec3 at;
        /// <summary>To where [mm]: of an advance.</summary>
        public RhexisVec3 to;
        /// <summary>The direction that the criterion chose: of an advance.</summary>
        public RhexisVec3 direction;
        /// <summary>The number that the kind names.</summary>
        public double value;
        /// <summary>Length [mm]: of a cut and a release.</summary>
        public double length;
        /// <summary>The count that the kind names.</summary>
        public ulong count;
        /// <summary>
        /// UTF-8: a reason or a name; empty where there is none. Valid until the next call of `rhexis_next_event` with this world.
        /// </summary>
        public IntPtr text;
    }

    /// <summary>Handle of a maker of haptic models. All bits zero: none.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct RhexisHaptics
    {
        /// <summary>Kind and serial number.</summary>
        public ulong bits;
    }

    /// <summary>The tissue at a tool, to first order.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct RhexisHapticModel
    {
        /// <summary>When it was made [ms].</summary>
        public double time;
        /// <summary>The tool's position then [mm].</summary>
        public RhexisVec3 position;
        /// <summary>Force of the tool on the tissue then [N]; the hand feels the opposite.</summary>
        public RhexisVec3 force;
        /// <summary>
        /// By how much the force grows along a motion of the tool [N/mm], column after column: symmetric, positive semidefinite.
        /// </summary>
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 9)]
        public double[] stiffness;
    }

    /// <summary>Handle of the haptic thread's end of a feed. All bits zero: none.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct RhexisReceiver
    {
        /// <summary>Kind and serial number.</summary>
        public ulong bits;
    }

    /// <summary>A rigid body that tissue pushes.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct RhexisRigid
    {
        /// <summary>Mass [g].</summary>
        public double mass;
        /// <summary>Centre of mass [mm].</summary>
        public RhexisVec3 centre;
        /// <summary>Velocity of the centre [mm/ms].</summary>
        public RhexisVec3 velocity;
        /// <summary>Angular velocity [rad/ms].</summary>
        public RhexisVec3 spin;
        /// <summary>Impulse of tissue in the last step [N ms].</summary>
        public RhexisVec3 impulse;
        /// <summary>Moment of the impulse about the centre [N mm ms].</summary>
        public RhexisVec3 angular_impulse;
    }

    /// <summary>A vertex that is pinned.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct RhexisPin
    {
        /// <summary>Its key.</summary>
        public ulong vertex;
        /// <summary>Where it is in the rest shape [mm].</summary>
        public RhexisVec3 rest_position;
        /// <summary>Where it is held [mm].</summary>
        public RhexisVec3 place;
    }

    /// <summary>Handle of a snapshot. All bits zero: none.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct RhexisSnapshot
    {
        /// <summary>Kind and serial number.</summary>
        public ulong bits;
    }

    /// <summary>Borrowed bytes, valid as long as the object that holds them.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct RhexisViewU8
    {
        /// <summary>The first byte; not to be read where `count` is 0.</summary>
        public IntPtr data;
        /// <summary>Number of bytes.</summary>
        public UIntPtr count;
    }

    /// <summary>Handle of a recording. All bits zero: none.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct RhexisRecording
    {
        /// <summary>Kind and serial number.</summary>
        public ulong bits;
    }

    /// <summary>
    /// Borrowed numbers in double precision, valid until the next call that changes the world, or asks for the same again.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct RhexisViewF64
    {
        /// <summary>The first number; not to be read where `count` is 0.</summary>
        public IntPtr data;
        /// <summary>Number of numbers: three per point.</summary>
        public UIntPtr count;
    }

    /// <summary>
    /// Borrowed numbers in single precision, valid until the next call that changes the world, or asks for the same again.
    /// </summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct RhexisViewF32
    {
        /// <summary>The first number; not to be read where `count` is 0.</summary>
        public IntPtr data;
        /// <summary>Number of numbers: three per point.</summary>
        public UIntPtr count;
    }

    /// <summary>Borrowed rows, valid until the next call that changes the world, or asks for the same again.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct RhexisViewU32
    {
        /// <summary>The first row; not to be read where `count` is 0.</summary>
        public IntPtr data;
        /// <summary>Number of rows.</summary>
        public UIntPtr count;
    }

    /// <summary>Borrowed keys, valid until the next call that changes the world, or asks for the same again.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct RhexisViewU64
    {
        /// <summary>The first key; not to be read where `count` is 0.</summary>
        public IntPtr data;
        /// <summary>Number of keys.</summary>
        public UIntPtr count;
    }

    /// <summary>What has changed in a body's mesh since it was last asked. Positions change everywhere in every step.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct RhexisChanges
    {
        /// <summary>1 where the whole mesh is new: the ranges span all rows.</summary>
        public byte is_whole;
        /// <summary>Number of vertices now: a copy is cut or extended to it.</summary>
        public uint vertex_count;
        /// <summary>Number of triangles now.</summary>
        public uint triangle_count;
        /// <summary>
        /// First row and row after the last, pair after pair, ascending: vertices that are new, have moved in the rest shape, or are now
        /// what another row was.
        /// </summary>
        public RhexisViewU32 vertices;
        /// <summary>The same of triangles that are new, have other corners, or are now what another row was.</summary>
        public RhexisViewU32 triangles;
    }

    /// <summary>How jaws hold; start from `rhexis_jaws_init`.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct RhexisJaws
    {
        /// <summary>Radius [mm, rest shape] of what is taken about the point.</summary>
        public double radius;
        /// <summary>Stiffness of the pinch [N/mm]; 0 for a constraint.</summary>
        public double stiffness;
        /// <summary>Most force [N] that they hold; 0 for no limit.</summary>
        public double force_limit;
        /// <summary>Not 0: beyond the limit the tissue slides; 0: they let go.</summary>
        public byte slides;
    }

    /// <summary>A unit quaternion x·i + y·j + z·k + w.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct RhexisQuat
    {
        /// <summary>Of i.</summary>
        public double x;
        /// <summary>Of j.</summary>
        public double y;
        /// <summary>Of k.</summary>
        public double z;
        /// <summary>The real part; 1 for no rotation.</summary>
        public double w;
    }

    /// <summary>Where a tool is and how it is turned.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct RhexisPose
    {
        /// <summary>[mm].</summary>
        public RhexisVec3 position;
        /// <summary>From the tool's frame to space; a unit quaternion.</summary>
        public RhexisQuat orientation;
    }

    /// <summary>What jaws close about; start from `rhexis_grasp_init`.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct RhexisGrasp
    {
        /// <summary>One of `RHEXIS_GRASP_NEAREST` and the others.</summary>
        public uint kind;
        /// <summary>How far the tissue may be [mm]: of NEAREST and RAY.</summary>
        public double reach;
        /// <summary>The point in the rest shape of POINT, the origin of RAY [mm].</summary>
        public RhexisVec3 point;
        /// <summary>Direction of RAY, of any length.</summary>
        public RhexisVec3 direction;
        /// <summary>Keys of the vertices of VERTICES.</summary>
        public IntPtr vertices;
        /// <summary>Their number.</summary>
        public UIntPtr vertex_count;
    }

    /// <summary>Forceps as they are.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct RhexisForcepsState
    {
        /// <summary>Where they are now.</summary>
        public RhexisPose pose;
        /// <summary>Force of the jaws on the tissue at the last step [N].</summary>
        public RhexisVec3 force;
        /// <summary>Torque about their position [N mm].</summary>
        public RhexisVec3 torque;
        /// <summary>The body that they hold; none where they are open.</summary>
        public RhexisEntity body;
        /// <summary>Distance of the hand from where the jaws draw the tissue to [mm]: above zero after steps that were limited.</summary>
        public double hand_ahead;
    }

    /// <summary>What a cut has done.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct RhexisCut
    {
        /// <summary>Length asked for [mm].</summary>
        public double asked;
        /// <summary>Length cut [mm, rest shape]; 0 where a blade has cut nothing yet.</summary>
        public double made;
        /// <summary>Largest distance [mm] of the cut from the line asked for.</summary>
        public double off_line;
        /// <summary>Smallest rest angle [rad] of the triangles touched.</summary>
        public double smallest_angle;
        /// <summary>Number of strokes.</summary>
        public ulong strokes;
        /// <summary>Number of tips left inside the tissue.</summary>
        public ulong tips;
        /// <summary>Number of fragments that came free.</summary>
        public ulong fragments;
    }

    /// <summary>A point of a body's surface.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct RhexisHit
    {
        /// <summary>Key of the triangle.</summary>
        public ulong triangle;
        /// <summary>Keys of its corners.</summary>
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)]
        public ulong[] corners;
        /// <summary>Weights of the corners, with sum 1.</summary>
        [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)]
        public double[] weights;
        /// <summary>The point [mm].</summary>
        public RhexisVec3 position;
        /// <summary>The same point of the tissue in the rest shape [mm].</summary>
        public RhexisVec3 rest_position;
        /// <summary>Unit normal of the triangle.</summary>
        public RhexisVec3 normal;
        /// <summary>From the ray's origin along the ray, or from the point [mm].</summary>
        public double distance;
    }

    /// <summary>Settings of a world; start from `rhexis_settings_init`. All others by `rhexis_settings_set`.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct RhexisSettings
    {
        /// <summary>One of `RHEXIS_ACCURACY_FAST` and the others.</summary>
        public uint accuracy;
        /// <summary>Threads of a step; 0 for one per core. Results have the same bits for any number.</summary>
        public uint threads;
        /// <summary>Iterations that a body may take in one step; 0 for what the accuracy says.</summary>
        public uint budget;
        /// <summary>Not 0: only instructions that every processor of the family has.</summary>
        public byte portable_instructions;
    }

    /// <summary>What a step did.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct RhexisReport
    {
        /// <summary>Steps done so far.</summary>
        public ulong step;
        /// <summary>Time reached [ms].</summary>
        public double time;
        /// <summary>Iterations of linear solves, of all bodies.</summary>
        public ulong iterations;
        /// <summary>Tear tips that are alive, of all bodies.</summary>
        public ulong tip_count;
        /// <summary>Steps of bodies, or parts of them, that were undone and retried.</summary>
        public uint rolled_back;
        /// <summary>1 where a body's step was given up: its last good state stands, and an event says why.</summary>
        public byte has_failed;
        /// <summary>1 where a solve has stopped because its time was up: the step would not be the same on every run.</summary>
        public byte is_late;
        /// <summary>1 where tears were due that the limits of the step have left to the next one.</summary>
        public byte is_cut_short;
    }

    /// <summary>The functions of the library.</summary>
    public static class Native
    {
        /// <summary>rhexis_c.dll, librhexis_c.so or librhexis_c.dylib; on iOS and WebGL "__Internal".</summary>
#if UNITY_IOS && !UNITY_EDITOR
        public const string Library = "__Internal";
#else
        public const string Library = "rhexis_c";
#endif

        /// <summary>Version of this interface: a library of another one is refused by `rhexis_check_abi`.</summary>
        public const uint RHEXIS_ABI_VERSION = 1;
        /// <summary>Feature bit: snapshots and recordings have a form as bytes.</summary>
        public const ulong RHEXIS_FEATURE_BYTES = 1;
        /// <summary>Feature bit: panics are caught at the boundary. Not of a library built with `panic = "abort"`.</summary>
        public const ulong RHEXIS_FEATURE_UNWIND = 2;
        /// <summary>Feature bit: the engine has sparse Cholesky factors (`--features direct`). Recordings of builds without the bit are refused.</summary>
        public const ulong RHEXIS_FEATURE_DIRECT = 4;
        /// <summary>There are no more events.</summary>
        public const uint RHEXIS_EVENT_NONE = 0;
        /// <summary>A tear began, by a cut or by the criterion: `tip`, `at`; `value` is the criterion, 0 for a cut.</summary>
        public const uint RHEXIS_EVENT_STARTED = 1;
        /// <summary>A tip moved on: `tip`, `at`, `to`, `direction`; `value` is the criterion; `text` says by which course.</summary>
        public const uint RHEXIS_EVENT_ADVANCED = 2;
        /// <summary>Energy released between two equilibria: `value` [mJ], `length` torn.</summary>
        public const uint RHEXIS_EVENT_RELEASED = 3;
        /// <summary>A tip reached a boundary and is gone: `tip`, `at`.</summary>
        public const uint RHEXIS_EVENT_ENDED = 4;
        /// <summary>A live tip was left at a notch or a branch: `tip`, `at`; `text` says which.</summary>
        public const uint RHEXIS_EVENT_RENEWED = 5;
        /// <summary>Tissue parted where no tip led: `at`; `value` is by how much it was too weak; `text` says why.</summary>
        public const uint RHEXIS_EVENT_PARTED = 6;
        /// <summary>A fragment came free: `count` triangles.</summary>
        public const uint RHEXIS_EVENT_FRAGMENT_FREED = 7;
        /// <summary>A tear stays shut where a hold keeps both lips: `at`.</summary>
        public const uint RHEXIS_EVENT_HELD_SHUT = 8;
        /// <summary>The mesh is too coarse at a tip: `tip`, `at`; `value` is edges per averaging radius, to be 3 or more.</summary>
        public const uint RHEXIS_EVENT_UNDER_RESOLVED = 9;
        /// <summary>A tip waits for `max_tear_speed`: `tip`, `at`; `value` is the criterion.</summary>
        public const uint RHEXIS_EVENT_HELD_BACK = 10;
        /// <summary>A nucleation was blocked by energy: `at`; `value` is the criterion; `length`.</summary>
        public const uint RHEXIS_EVENT_NUCLEATION_BLOCKED = 11;
        /// <summary>An advance that the mesh could not make: `tip`, `at`; `text` says why.</summary>
        public const uint RHEXIS_EVENT_REFUSED = 12;
        /// <summary>Jaws were pulled beyond their limit: `value` [N]; `count` is 1 where they have let go; `text` is their name.</summary>
        public const uint RHEXIS_EVENT_SLIPPED = 13;
        /// <summary>A body fell asleep.</summary>
        public const uint RHEXIS_EVENT_FELL_ASLEEP = 14;
        /// <summary>A body woke: `text` says by what.</summary>
        public const uint RHEXIS_EVENT_WOKE = 15;
        /// <summary>The guard against created energy began to act: `count` attempts were undone.</summary>
        public const uint RHEXIS_EVENT_STEP_GUARDED = 16;
        /// <summary>A step was given up, the last good state stands: `text` says why.</summary>
        public const uint RHEXIS_EVENT_STEP_FAILED = 17;
        /// <summary>A tool has cut: `length` [mm, rest shape], `value` the length asked for, `count` strokes.</summary>
        public const uint RHEXIS_EVENT_CUT = 18;
        /// <summary>Something that has no number here yet: `text` says what.</summary>
        public const uint RHEXIS_EVENT_OTHER = 19;
        /// <summary>Jaws close about the point of the surface nearest to them.</summary>
        public const uint RHEXIS_GRASP_NEAREST = 0;
        /// <summary>Jaws close about the first point of the surface on a ray.</summary>
        public const uint RHEXIS_GRASP_RAY = 1;
        /// <summary>Jaws close about a point of the rest shape.</summary>
        public const uint RHEXIS_GRASP_POINT = 2;
        /// <summary>Jaws close on the vertices given, and no others.</summary>
        public const uint RHEXIS_GRASP_VERTICES = 3;
        /// <summary>Preset: the engine's defaults.</summary>
        public const uint RHEXIS_ACCURACY_FAST = 0;
        /// <summary>Preset: steps for a hand that feels them.</summary>
        public const uint RHEXIS_ACCURACY_HAPTIC = 1;
        /// <summary>Preset: steps that are looked at, with a budget of 80 iterations' work.</summary>
        public const uint RHEXIS_ACCURACY_GAME = 2;
        /// <summary>Preset: steps that are right rather than fast.</summary>
        public const uint RHEXIS_ACCURACY_ACCURATE = 3;
        /// <summary>Preset: equilibria by `rhexis_settle`.</summary>
        public const uint RHEXIS_ACCURACY_STATIC = 4;

        /// <summary>
        /// Tells whether header and library fit: call it first, as `rhexis_check_abi(RHEXIS_ABI_VERSION, 0)`, or with the feature bits that
        /// the host relies on.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_check_abi(uint abi_version, ulong features_needed);

        /// <summary>Tells how the library was built.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_build_info(out RhexisBuildInfo info);

        /// <summary>
        /// Fills a description with the material of Figure 2 of Allard, Marchal and Cotin 2009, fibres along x, and no mesh.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_body_init(out RhexisBodyDesc body);

        /// <summary>
        /// Puts a body into the world; the arrays are copied. Give it components by `rhexis_set`: it tears with "Tearing".
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_body_create(RhexisWorld world, ref RhexisBodyDesc desc, out RhexisEntity body);

        /// <summary>
        /// Gives all triangles of a body another material while it runs: tissue that ages or dries. Of the description only the material counts,
        /// from `young_fibre` to `density`. Positions, fibres and components stay.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_material_set(RhexisWorld world, RhexisEntity body, ref RhexisBodyDesc desc);

        /// <summary>
        /// Puts an obstacle into the world, a shape in TOML such as "shape = { Sphere = { centre = [0, 0, -5], radius = 4 } }". Bodies with
        /// the component "Contact" touch it; `rhexis_set` with "Obstacle" moves it.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_obstacle_create(
            RhexisWorld world,
            [MarshalAs(UnmanagedType.LPUTF8Str)] string toml,
            out RhexisEntity obstacle);

        /// <summary>
        /// Makes an obstacle a rigid body that tissue pushes, or changes its motion: TOML such as "mass = 2.0\nacceleration = [0, 0, -9.81e-3]" with
        /// the keys of `RhexisRigid` and "acceleration" and "inertia". A new one needs its mass [g], from which centre and inertia follow by its
        /// shape. An empty text takes the mass away. Its place is set by `rhexis_set` with "Obstacle".
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_rigid_set(
            RhexisWorld world,
            RhexisEntity obstacle,
            [MarshalAs(UnmanagedType.LPUTF8Str)] string toml);

        /// <summary>
        /// Mass and motion of a rigid obstacle, and the impulse of tissue in the last step; a mass of 0 for an obstacle that yields to nothing.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_rigid(RhexisWorld world, RhexisEntity obstacle, out RhexisRigid rigid);

        /// <summary>The name of a component by number, from 0 on; NULL past the last. Valid for ever.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern IntPtr rhexis_component_name(UIntPtr index);

        /// <summary>
        /// Gives a body, an obstacle or a tool a component, or changes the one that it has: "Tearing" with "strength_across_fibres = 0.8", say.
        /// Keys that the text does not name keep their values, or those of the default where the component is new and has one. The
        /// component is judged as a whole; nothing has changed where it is refused.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_set(
            RhexisWorld world,
            RhexisEntity entity,
            [MarshalAs(UnmanagedType.LPUTF8Str)] string component,
            [MarshalAs(UnmanagedType.LPUTF8Str)] string toml);

        /// <summary>Takes a component off a body or an obstacle. `was_there` gets 1 or 0, and may be NULL.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_unset(
            RhexisWorld world,
            RhexisEntity entity,
            [MarshalAs(UnmanagedType.LPUTF8Str)] string component,
            out byte was_there);

        /// <summary>
        /// Writes a component as TOML into a buffer, with a zero at the end that `count` counts too: all its keys, as `rhexis_set` reads
        /// them.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_get(
            RhexisWorld world,
            RhexisEntity entity,
            [MarshalAs(UnmanagedType.LPUTF8Str)] string component,
            [Out] byte[] buffer,
            UIntPtr capacity,
            out UIntPtr count);

        /// <summary>Takes the next event since the last step, in order; one of kind `RHEXIS_EVENT_NONE` where there are no more.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_next_event(RhexisWorld world, out RhexisEvent @event);

        /// <summary>
        /// Makes a maker of haptic models for one tool, and its feed. `horizon` [ms]: models hold for motions slower than that; with the
        /// length of a step it is the answer that the step will give, with 1000 that in equilibrium.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_haptics_create(double horizon, out RhexisHaptics haptics);

        /// <summary>Destroys a maker. Its receivers keep the last model.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_haptics_destroy(RhexisHaptics haptics);

        /// <summary>Makes the model of the tissue at closed forceps, and sends it to the receivers. `model` may be NULL.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_haptics_model(
            RhexisHaptics haptics,
            RhexisWorld world,
            RhexisEntity forceps,
            out RhexisHapticModel model);

        /// <summary>
        /// Makes the model that follows the last one of the same forceps at a part of its cost, and sends it. `model` may be NULL.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_haptics_refresh(
            RhexisHaptics haptics,
            RhexisWorld world,
            RhexisEntity forceps,
            out RhexisHapticModel model);

        /// <summary>Makes the model of the tissue at the pins of a name, and sends it. `model` may be NULL.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_haptics_model_of_pins(
            RhexisHaptics haptics,
            RhexisWorld world,
            RhexisEntity body,
            [MarshalAs(UnmanagedType.LPUTF8Str)] string name,
            out RhexisHapticModel model);

        /// <summary>
        /// Makes an end of a maker's feed for one haptic thread. `interval` [ms]: within that each model takes the place of the last, best
        /// the time between two models; 0 lets forces jump.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_receiver_create(RhexisHaptics haptics, double interval, out RhexisReceiver receiver);

        /// <summary>Destroys an end of a feed.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_receiver_destroy(RhexisReceiver receiver);

        /// <summary>The last model sent; NOT_FOUND before the first. Does not wait for a step.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_receiver_latest(RhexisReceiver receiver, out RhexisHapticModel model);

        /// <summary>
        /// Force of the tool on the tissue [N] with the tool at a position [mm], `elapsed` [ms] after the last call: without jumps from
        /// model to model, and without energy that the hand has not put in. The hand feels the opposite. NOT_FOUND before the first model.
        /// Does not wait for a step.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_receiver_force(
            RhexisReceiver receiver,
            double elapsed,
            RhexisVec3 position,
            out RhexisVec3 force);

        /// <summary>Force of the tool on the tissue [N] by one model, with the tool at a position [mm].</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_haptic_force_at(ref RhexisHapticModel model, RhexisVec3 position, out RhexisVec3 force);

        /// <summary>Holds vertices where they are now, under a name; those already held under it stay held.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_pin(
            RhexisWorld world,
            RhexisEntity body,
            [MarshalAs(UnmanagedType.LPUTF8Str)] string name,
            ulong[] vertices,
            UIntPtr vertex_count);

        /// <summary>Lets vertices go, whoever holds them.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_unpin(RhexisWorld world, RhexisEntity body, ulong[] vertices, UIntPtr vertex_count);

        /// <summary>Lets go what is pinned under a name, copies that tears have made included.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_unpin_all(
            RhexisWorld world,
            RhexisEntity body,
            [MarshalAs(UnmanagedType.LPUTF8Str)] string name);

        /// <summary>Writes what is pinned under a name into a buffer, in the order of rows, and its number. Tears add copies.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_pins(
            RhexisWorld world,
            RhexisEntity body,
            [MarshalAs(UnmanagedType.LPUTF8Str)] string name,
            [Out] RhexisPin[] buffer,
            UIntPtr capacity,
            out UIntPtr count);

        /// <summary>Moves what is pinned under a name by a way [mm] from where it is held, reached at the end of the next step.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_pins_shift(
            RhexisWorld world,
            RhexisEntity body,
            [MarshalAs(UnmanagedType.LPUTF8Str)] string name,
            RhexisVec3 way);

        /// <summary>
        /// Moves what is pinned under a name to places [mm], three numbers each, in the order and number of `rhexis_pins`; reached at the
        /// end of the next step.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_pins_move(
            RhexisWorld world,
            RhexisEntity body,
            [MarshalAs(UnmanagedType.LPUTF8Str)] string name,
            double[] places,
            UIntPtr place_count);

        /// <summary>The force [N] of a hold or of pins on a body at the last step. Does not change the world.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_reaction(
            RhexisWorld world,
            RhexisEntity body,
            [MarshalAs(UnmanagedType.LPUTF8Str)] string name,
            out RhexisVec3 force);

        /// <summary>Takes a snapshot of the whole state, to go back to and to go on from to the same bits.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_snapshot_take(RhexisWorld world, out RhexisSnapshot snapshot);

        /// <summary>Destroys a snapshot, and the bytes that it has lent.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_snapshot_destroy(RhexisSnapshot snapshot);

        /// <summary>Lends the bytes of a snapshot, valid until it is destroyed.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_snapshot_bytes(RhexisSnapshot snapshot, out RhexisViewU8 bytes);

        /// <summary>Makes a snapshot of bytes, from wherever they come: they are judged.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_snapshot_from_bytes(byte[] data, UIntPtr count, out RhexisSnapshot snapshot);

        /// <summary>
        /// Goes back to a snapshot, of this world or of another one: bodies, obstacles and tools are those of the snapshot. Handles of this
        /// world name in it what they named when it was taken of this world.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_restore(RhexisWorld world, RhexisSnapshot snapshot);

        /// <summary>
        /// Makes a world that goes on from a snapshot, with as many threads as its settings ask for; not driven by a scene.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_world_from_snapshot(RhexisSnapshot snapshot, out RhexisWorld world);

        /// <summary>Writes down from now on what is done to a world.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_record(RhexisWorld world);

        /// <summary>Ends the recording of a world. Refused where none was made.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_record_end(RhexisWorld world, out RhexisRecording recording);

        /// <summary>Destroys a recording, and the bytes that it has lent.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_recording_destroy(RhexisRecording recording);

        /// <summary>Lends the bytes of a recording, valid until it is destroyed.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_recording_bytes(RhexisRecording recording, out RhexisViewU8 bytes);

        /// <summary>Makes a recording of bytes, from wherever they come: they are judged.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_recording_from_bytes(byte[] data, UIntPtr count, out RhexisRecording recording);

        /// <summary>
        /// Does once more what was recorded, to the same hash or to a refusal, and makes a world of its end. `world` may be NULL.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_replay(RhexisRecording recording, out RhexisWorld world);

        /// <summary>Lends the positions [mm], three numbers per vertex.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_positions(RhexisWorld world, RhexisEntity body, out RhexisViewF64 view);

        /// <summary>Lends a copy of the positions [mm] in single precision, three numbers per vertex.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_positions_f32(RhexisWorld world, RhexisEntity body, out RhexisViewF32 view);

        /// <summary>
        /// Lends the positions [mm] at a time `behind` [ms] before now, on straight lines from where the last step began: for pictures
        /// between two steps.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_positions_before(
            RhexisWorld world,
            RhexisEntity body,
            double behind,
            out RhexisViewF64 view);

        /// <summary>Lends the positions of the rest shape [mm], three numbers per vertex.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_rest_positions(RhexisWorld world, RhexisEntity body, out RhexisViewF64 view);

        /// <summary>Lends the velocities [mm/ms], three numbers per vertex.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_velocities(RhexisWorld world, RhexisEntity body, out RhexisViewF64 view);

        /// <summary>Lends unit normals by vertex, three numbers each: means of the triangles around it, weighted by area.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_normals(RhexisWorld world, RhexisEntity body, out RhexisViewF64 view);

        /// <summary>Lends unit normals by vertex in single precision, three numbers each.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_normals_f32(RhexisWorld world, RhexisEntity body, out RhexisViewF32 view);

        /// <summary>Lends the corners of the triangles, three rows each, counter-clockwise seen from where the normal points.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_indices(RhexisWorld world, RhexisEntity body, out RhexisViewU32 view);

        /// <summary>Lends the keys of the vertices: they name a vertex as long as it lives, wherever its row is.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_vertex_keys(RhexisWorld world, RhexisEntity body, out RhexisViewU64 view);

        /// <summary>Lends the keys of the triangles.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_triangle_keys(RhexisWorld world, RhexisEntity body, out RhexisViewU64 view);

        /// <summary>
        /// Lends the host's own numbers per vertex of a body with the component "Attributes", and how many belong to a vertex. `stride` may
        /// be NULL.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_attributes(
            RhexisWorld world,
            RhexisEntity body,
            out RhexisViewF64 view,
            out UIntPtr stride);

        /// <summary>Lends a copy of the host's own numbers per vertex in single precision. `stride` may be NULL.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_attributes_f32(
            RhexisWorld world,
            RhexisEntity body,
            out RhexisViewF32 view,
            out UIntPtr stride);

        /// <summary>Keeps from now on what changes in a body's mesh, for `rhexis_changes`; the first answer is the whole mesh.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_track_changes(RhexisWorld world, RhexisEntity body);

        /// <summary>
        /// Tells which rows of a body's mesh have changed since the last call: what a renderer has to copy again of its indices, texture
        /// coordinates and colours. For a body of `rhexis_track_changes`.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_changes(RhexisWorld world, RhexisEntity body, out RhexisChanges changes);

        /// <summary>
        /// Why the last call of this thread failed that did: UTF-8, valid until the next one fails or the thread ends; empty before the
        /// first.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern IntPtr rhexis_last_error_message();

        /// <summary>The name of a status, such as "BUSY"; "UNKNOWN" for a number that is none. Valid for ever.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern IntPtr rhexis_status_name(int status);

        /// <summary>Fills jaws with a constraint of radius 0.2 mm without a limit.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_jaws_init(out RhexisJaws jaws);

        /// <summary>Fills a pose at the origin, not turned.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_pose_init(out RhexisPose pose);

        /// <summary>Fills a grasp of the nearest point within 1 mm.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_grasp_init(out RhexisGrasp grasp);

        /// <summary>Puts open forceps into the world. `name` may be NULL for "forceps".</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_forceps_create(
            RhexisWorld world,
            [MarshalAs(UnmanagedType.LPUTF8Str)] string name,
            ref RhexisJaws jaws,
            ref RhexisPose pose,
            out RhexisEntity forceps);

        /// <summary>Closes forceps on a body. `held` gets the number of vertices that they hold, and may be NULL.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_forceps_close(
            RhexisWorld world,
            RhexisEntity forceps,
            RhexisEntity body,
            ref RhexisGrasp grasp,
            out UIntPtr held);

        /// <summary>Moves forceps to a pose, evenly within a time [ms]: that of the step or frame about to be simulated.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_forceps_move(RhexisWorld world, RhexisEntity forceps, ref RhexisPose pose, double within);

        /// <summary>Opens forceps: they let go.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_forceps_open(RhexisWorld world, RhexisEntity forceps);

        /// <summary>Tells where forceps are, what they hold, and with which force. Does not change the world.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_forceps_state(RhexisWorld world, RhexisEntity forceps, out RhexisForcepsState state);

        /// <summary>Cuts a body along a line through points of the rest shape [mm], three numbers each. `cut` may be NULL.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_cut(
            RhexisWorld world,
            RhexisEntity body,
            double[] points,
            UIntPtr point_count,
            out RhexisCut cut);

        /// <summary>
        /// Punctures a body where its surface is nearest to a point [mm]: a slit of a length [mm, rest shape] along a direction. `cut` may
        /// be NULL.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_puncture(
            RhexisWorld world,
            RhexisEntity body,
            RhexisVec3 point,
            RhexisVec3 direction,
            double length,
            out RhexisCut cut);

        /// <summary>
        /// Puts a blade into the world, out of any tissue: it cuts surface within `reach` [mm], in strokes of at least `least` [mm].
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_blade_create(RhexisWorld world, double reach, double least, out RhexisEntity blade);

        /// <summary>
        /// Draws the edge of a blade to a point [mm], where it cuts a body from where it was; call it every frame. `cut` gets what it has
        /// cut, zeros where it has saved the stroke up, and may be NULL.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_blade_draw(
            RhexisWorld world,
            RhexisEntity blade,
            RhexisEntity body,
            RhexisVec3 edge,
            out RhexisCut cut);

        /// <summary>
        /// Finds the point of a body's surface that is nearest to a point, no farther than `within` [mm]. Does not change the world.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_nearest(
            RhexisWorld world,
            RhexisEntity body,
            RhexisVec3 point,
            double within,
            out RhexisHit hit);

        /// <summary>Finds the first point of a body's surface on a ray, no farther than `within` [mm]. Does not change the world.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_cast_ray(
            RhexisWorld world,
            RhexisEntity body,
            RhexisVec3 origin,
            RhexisVec3 direction,
            double within,
            out RhexisHit hit);

        /// <summary>Pushes a vertex with a force [N] for the next step.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_apply_force(RhexisWorld world, RhexisEntity body, ulong vertex, RhexisVec3 force);

        /// <summary>Fills settings with the defaults.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_settings_init(out RhexisSettings settings);

        /// <summary>Makes an empty world at time zero. `settings` may be NULL for the defaults.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_world_create(ref RhexisSettings settings, out RhexisWorld world);

        /// <summary>
        /// Makes a world from a scene's text, TOML as `rhexis scenes --show NAME` prints it. `origin` names the text in errors and may be
        /// NULL. Mesh files that the text names are looked for in the working directory. `rhexis_advance` does the scene's steps.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_world_from_scene(
            [MarshalAs(UnmanagedType.LPUTF8Str)] string text,
            [MarshalAs(UnmanagedType.LPUTF8Str)] string origin,
            out RhexisWorld world);

        /// <summary>Makes a world from a scene of the catalog, such as "fig2-tear".</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_world_from_catalog(
            [MarshalAs(UnmanagedType.LPUTF8Str)] string name,
            out RhexisWorld world);

        /// <summary>Destroys a world and all that it has lent. A world that has failed too.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_world_destroy(RhexisWorld world);

        /// <summary>Moves the world on by `dt` [ms]. `report` may be NULL.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_step(RhexisWorld world, double dt, out RhexisReport report);

        /// <summary>
        /// Does the next step of a scene: its time step, its timed cuts and tools, its mode. `report` may be NULL. Refused for a world that
        /// is not from a scene.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_advance(RhexisWorld world, out RhexisReport report);

        /// <summary>Tells whether a scene is at its end: 1, or 0. A scene that is may be advanced further.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_is_finished(RhexisWorld world, out byte is_finished);

        /// <summary>
        /// Moves time on by `dt` [ms] and finds the equilibrium there, to `tolerance`, a fraction of the largest corner force. `report` may
        /// be NULL.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_settle(RhexisWorld world, double dt, double tolerance, out RhexisReport report);

        /// <summary>
        /// Limits the next steps: iterations that a body may take in one step, and time of a solve [ms], after which the step is not the
        /// same on every run; 0 for no limit.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_set_budget(RhexisWorld world, uint iterations, double milliseconds);

        /// <summary>
        /// Changes settings of the next steps by TOML, such as "max_tear_passes = 2"; what it does not name stays. `rhexis_settings_get` shows all.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_settings_set(RhexisWorld world, [MarshalAs(UnmanagedType.LPUTF8Str)] string toml);

        /// <summary>Writes the settings as TOML into a buffer, with a zero at the end that `count` counts too.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_settings_get(RhexisWorld world, [Out] byte[] buffer, UIntPtr capacity, out UIntPtr count);

        /// <summary>
        /// Writes the likely slips in all that a world holds into a buffer, one per line, with a zero at the end that `count` counts too: wrong units, missing
        /// holds. `dt` is the time step [ms] that is meant, `duration` that of the run [ms], 0 where it is not known. A world from a scene has those of its scene,
        /// whatever these are.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_doubts(RhexisWorld world, double dt, double duration, [Out] byte[] buffer, UIntPtr capacity, out UIntPtr count);

        /// <summary>Time reached [ms].</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_time(RhexisWorld world, out double time);

        /// <summary>Writes the bodies in order of spawning into a buffer, and their number.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_bodies(
            RhexisWorld world,
            [Out] RhexisEntity[] buffer,
            UIntPtr capacity,
            out UIntPtr count);

        /// <summary>Finds the body of a name.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_find_body(
            RhexisWorld world,
            [MarshalAs(UnmanagedType.LPUTF8Str)] string name,
            out RhexisEntity body);

        /// <summary>Takes a body, an obstacle or a tool out of the world.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_entity_destroy(RhexisWorld world, RhexisEntity entity);

        /// <summary>
        /// The hash of state and topology: equal for equal runs on every platform of equal arithmetic, from C, Rust or any other language.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern RhexisStatus rhexis_hash(RhexisWorld world, out ulong hash);
    }

    /// <summary>A call that did nothing, and why.</summary>
    public sealed class RhexisException : Exception
    {
        public RhexisStatus Status { get; }

        public RhexisException(RhexisStatus status, string message) : base(status + ": " + message) { Status = status; }

        /// <summary>Throws unless the call was done.</summary>
        public static void Check(RhexisStatus status)
        {
            if (status != RhexisStatus.Ok)
            {
                throw new RhexisException(status, Marshal.PtrToStringUTF8(Native.rhexis_last_error_message()) ?? "");
            }
        }
    }

    /// <summary>Copies of what views point at.</summary>
    public static class RhexisView
    {
        public static double[] ToArray(this RhexisViewF64 view)
        {
            var copy = new double[(int)view.count];
            if (copy.Length > 0) { Marshal.Copy(view.data, copy, 0, copy.Length); }
            return copy;
        }

        public static float[] ToArray(this RhexisViewF32 view)
        {
            var copy = new float[(int)view.count];
            if (copy.Length > 0) { Marshal.Copy(view.data, copy, 0, copy.Length); }
            return copy;
        }

        /// <summary>Rows as Unity's meshes take them.</summary>
        public static int[] ToArray(this RhexisViewU32 view)
        {
            var copy = new int[(int)view.count];
            if (copy.Length > 0) { Marshal.Copy(view.data, copy, 0, copy.Length); }
            return copy;
        }

        /// <summary>Keys of vertices.</summary>
        public static ulong[] ToArray(this RhexisViewU64 view)
        {
            var bits = new long[(int)view.count];
            if (bits.Length > 0) { Marshal.Copy(view.data, bits, 0, bits.Length); }
            return Array.ConvertAll(bits, key => unchecked((ulong)key));
        }

        public static byte[] ToArray(this RhexisViewU8 view)
        {
            var copy = new byte[(int)view.count];
            if (copy.Length > 0) { Marshal.Copy(view.data, copy, 0, copy.Length); }
            return copy;
        }
    }
}
