// SPDX-License-Identifier: GPL-3.0-or-later
// A job type of Flamenco 3.8 (its author API is the same in 3.9): stripes or quads on a moving mesh, by ranges of frames.
// Each task solves a contiguous range, every frame from the one before, saves a .blend of it, and may render it.

const JOB_TYPE = {
    label: "Synch Fields Animation",
    description: "Solve a pattern in each frame of a moving mesh, and render it",
    settings: [
        { key: "frames", type: "string", required: true,
          eval: "f'{C.scene.frame_start}-{C.scene.frame_end}'",
          evalInfo: { showLinkButton: true, description: "Scene frame range" },
          description: "Frames to solve. Examples: '47', '1-30', '3, 5-10, 47-327'" },
        { key: "chunk_size", type: "int32", default: 40, propargs: { min: 1 }, visible: "submission",
          description: "Frames that one task solves, each from the one before; the pattern starts afresh with a task" },
        { key: "object", type: "string", required: true, eval: "C.active_object.name if C.active_object else ''",
          evalInfo: { showLinkButton: true, description: "Active object" },
          description: "Mesh object that carries the pattern" },
        { key: "pattern", type: "string", required: true, choices: ["stripes", "quads"], default: "stripes",
          description: "What is solved" },
        { key: "spacing", type: "float", default: 0, propargs: { min: 0 }, visible: "submission",
          description: "Distance between two stripes; 0 for that which each task finds by itself" },
        { key: "flags", type: "string", default: "", visible: "submission",
          description: "More flags of synch animate. Example: --guidance curvature-min --seed 3" },
        { key: "output_folder", type: "string", subtype: "dir_path", required: true, visible: "submission",
          description: "Where the .blend files and reports go, on storage that all workers share" },
        { key: "render_output_path", type: "string", subtype: "file_path", default: "", visible: "submission",
          description: "Where rendered frames go, such as /shared/render/walk.######; empty to render nothing" },

        // Found without asking:
        { key: "blendfile", type: "string", required: true, visible: "web", description: "The file with the moving mesh" },
        { key: "format", type: "string", required: true, visible: "web",
          eval: "C.scene.render.image_settings.file_format", description: "Of rendered frames" },
    ]
};

function compileJob(job) {
    const settings = job.settings;
    const ranges = contiguousRanges(settings.frames, settings.chunk_size);
    if (ranges.length > 1 && !settings.spacing) {
        throw "give a spacing: each task would find another one by itself";
    }
    for (const [first, last] of ranges) {
        const name = `${padded(first)}-${padded(last)}`;
        const result = path.join(settings.output_folder, `${path.stem(settings.blendfile)}.${name}.blend`);
        const task = author.Task(`solve-${name}`, "blender");
        task.addCommand(blender(settings.blendfile, solveArguments(settings, first, last, result)));
        if (settings.render_output_path) {
            task.addCommand(blender(result, [
                "--render-output", settings.render_output_path,
                "--render-format", settings.format,
                "--render-frame", `${first}..${last}`,
            ]));
        }
        job.addTask(task);
    }
}

function blender(blendfile, args) {
    return author.Command("blender-render", {
        exe: "{blender}",
        exeArgs: "{blenderArgs}",
        argsBefore: [],
        blendfile: blendfile,
        args: args,
    });
}

function solveArguments(settings, first, last, result) {
    const spacing = settings.spacing ? ["--spacing", `${settings.spacing}`] : [];
    return [
        "--command", "synch", "animate",
        "--object", settings.object,
        "--pattern", settings.pattern,
        "--frames", `${first}`, `${last}`,
        ...spacing,
        ...shellSplit(settings.flags || ""),
        "--output", result,
        "--report", result.replace(/\.blend$/, ".json"),
    ];
}

// Runs of frames that follow one another, cut into pieces of a size: a gap would break the way from frame to frame.
function contiguousRanges(frames, size) {
    const ranges = [];
    for (const text of frameChunker(frames, 1)) {
        const frame = parseInt(text);
        const current = ranges[ranges.length - 1];
        if (current && frame === current[1] + 1 && frame - current[0] < size) {
            current[1] = frame;
        } else {
            ranges.push([frame, frame]);
        }
    }
    return ranges;
}

function padded(frame) {
    return `${frame}`.padStart(4, "0");
}
