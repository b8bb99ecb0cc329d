// SPDX-License-Identifier: GPL-3.0-or-later
// A stand-in of what Flamenco gives to job types: prints the tasks that a script authors for the job on standard input.
//
//     node flamenco.mjs script.js < job.json

import { readFileSync } from "node:fs";
import path from "node:path";
import vm from "node:vm";

function explode(range) {
    const frames = new Set();
    for (const part of range.replaceAll("..", "-").split(",")) {
        const ends = part.split("-").map((text) => {
            if (!/^\s*\d+\s*$/.test(text)) throw new Error(`invalid range "${range}"`);
            return parseInt(text);
        });
        for (let frame = ends[0]; frame <= ends[ends.length - 1]; frame++) frames.add(frame);
    }
    return [...frames].sort((a, b) => a - b);
}

const author = {
    Task: (name, type) => {
        if (!name.trim() || !type.trim()) throw new Error("author.Task(name, type): both are required");
        const task = { name, type, commands: [], dependencies: [] };
        task.addCommand = (command) => task.commands.push(command);
        task.addDependency = (other) => task.dependencies.push(other.name);
        return task;
    },
    Command: (name, parameters) => ({ name, parameters }),
};
const job = JSON.parse(readFileSync(0, "utf8"));
const tasks = [];
job.addTask = (task) => tasks.push(task);
const context = {
    author,
    path: {
        join: path.posix.join,
        basename: (name) => path.posix.basename(name),
        dirname: path.posix.dirname,
        stem: (name) => path.posix.parse(name).name,
    },
    print: () => {},
    alert: () => {},
    shellSplit: (text) => (text.match(/"[^"]*"|\S+/g) || []).map((part) => part.replaceAll('"', "")),
    frameChunker: (range, size) => {
        if (size !== 1) throw new Error("only single frames here");
        return explode(range).map(String);
    },
    frameCount: (range) => explode(range).length,
    formatTimestampLocal: () => "2026-01-01_000000",
};
const source = readFileSync(process.argv[2], "utf8");
const [type, compileJob] = vm.runInNewContext(`${source}\n;[JOB_TYPE, compileJob]`, context);
for (const setting of type.settings) {
    if (!(setting.key in job.settings) && "default" in setting) job.settings[setting.key] = setting.default;
    if (setting.required && !(setting.key in job.settings)) throw new Error(`the setting ${setting.key} is missing`);
}
compileJob(job);
console.log(JSON.stringify({ type, tasks }));
