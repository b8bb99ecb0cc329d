// SPDX-License-Identifier: GPL-3.0-or-later
// A job type of Flamenco 3.8 (its author API is the same in 3.9): the rows of a batch, in parts.
// Each task does one part; the last one does what is left, writes the table and the contact sheet, and fails where rows have failed.

const JOB_TYPE = {
    label: "Synch Fields Batch",
    description: "Run the commands of a JSON Lines file",
    settings: [
        { key: "rows", type: "string", subtype: "file_path", required: true, visible: "submission",
          description: "JSON Lines file, a command a line, on storage that all workers share" },
        { key: "working_folder", type: "string", subtype: "dir_path", required: true, visible: "submission",
          description: "Shared folder that the paths in the rows start from" },
        { key: "output_folder", type: "string", subtype: "dir_path", required: true, visible: "submission",
          description: "Where records, summary.csv, summary.json and sheet.html go, on shared storage" },
        { key: "parts", type: "int32", default: 10, propargs: { min: 1 }, visible: "submission",
          description: "Tasks that the rows are spread over" },
        { key: "processes", type: "int32", default: 4, propargs: { min: 1 }, visible: "submission",
          description: "Processes of a task, one a core" },
    ]
};

function compileJob(job) {
    const settings = job.settings;
    const last = author.Task("table-and-sheet", "blender");
    last.addCommand(batch(settings, []));
    for (let part = 1; part <= settings.parts; part++) {
        const task = author.Task(`part-${part}`, "blender");
        task.addCommand(batch(settings, ["--share", `${part}/${settings.parts}`]));
        job.addTask(task);
        last.addDependency(task);
    }
    job.addTask(last);
}

function batch(settings, flags) {
    return author.Command("exec", {
        exe: "{blender}",
        args: [
            "--background", "--command", "synch", "batch", settings.rows,
            "--working-folder", settings.working_folder,
            "--folder", settings.output_folder,
            "--jobs", `${settings.processes}`,
            ...flags,
        ],
    });
}
