// SPDX-License-Identifier: MIT
// A job type of Flamenco: index a folder on the workers of the farm, each task with its own part of the files.
// Copy this file into the folder "scripts" beside Flamenco Manager, and start the Manager again.

const JOB_TYPE = {
    label: "Shape Google Index",
    settings: [
        { key: "folder", type: "string", subtype: "dir_path", required: true,
          description: "Folder with the files to index; a path that all workers have" },
        { key: "library", type: "string", required: true, default: "postgresql://farm@server/shapes",
          description: "Address of the library, without password: that belongs into ~/.pgpass of the workers" },
        { key: "parts", type: "int32", required: true, default: 16,
          description: "Number of tasks; a few for each worker" },
        { key: "jobs", type: "int32", required: true, default: 4,
          description: "Processes of each task" },
        { key: "program", type: "string", required: true, default: "shapegoogle",
          description: "Command of the workers; with .blend files that of a Python which has bpy, such as " +
              "/opt/blender-python/bin/python /opt/shapegoogle/scripts/index_library.py" },
    ],
};

function compileJob(job) {
    const settings = job.settings;
    for (let part = 1; part <= settings.parts; part++) {
        const options = [settings.folder, "--library", settings.library,
            "--shard", `${part}/${settings.parts}`, "--jobs", `${settings.jobs}`];
        // The script for Blender is the command "index" itself.
        const program = settings.program + (settings.program.endsWith(".py") ? "" : " index");
        const task = author.Task(`part ${part} of ${settings.parts}`, "misc");
        // Exit code 1 means that some files could not be read, which another worker could not read either.
        task.addCommand(author.Command("exec", {
            exe: "sh",
            args: ["-c", `${program} "$@" || [ $? -eq 1 ]`, "sh", ...options],
        }));
        job.addTask(task);
    }
}
