"""What the programs that open our outputs have in common: each loads every job it knows and writes
the vertices it found as JSON."""
import json
import traceback


def write(jobs_path, answers_path, version, loaders, before=lambda job: None):
    """`loaders` gives for a kind of job the function that returns its positions; `before` is called first."""
    answers = {}
    with open(jobs_path) as file:
        jobs = json.load(file)
    for job in jobs:
        if job["kind"] not in loaders:
            continue
        try:
            before(job)
            answers[job["kind"]] = {"positions": loaders[job["kind"]](job)}
        except Exception as error:
            traceback.print_exc()
            answers[job["kind"]] = {"error": str(error)}
    with open(answers_path, "w") as file:
        json.dump({"version": version, "answers": answers}, file)
