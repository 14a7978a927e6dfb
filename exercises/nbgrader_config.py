"""The course's settings for nbgrader; `make release` and `make grade` read them too."""

from nbgrader import preprocessors

c = get_config()  # noqa: F821

c.CourseDirectory.course_id = "distmesh_edu"

# What a student finds where the solution stood. In a function it leaves the docstring, which is valid code.
c.ClearSolutions.code_stub = {"python": "# Your answer here."}

# A check that a student deleted is put back from the source, so that their answer still earns its points.
c.OverwriteCells.add_missing_cells = True


class ForgetCopies(preprocessors.DeduplicateIds):
    """Of a cell that a student copied, let the last one count: nbgrader 0.9 begins so, and then fails on the others."""

    def preprocess_cell(self, cell, resources, cell_index):
        cell, resources = super().preprocess_cell(cell, resources, cell_index)
        if cell.metadata.get("nbgrader") == {}:
            del cell.metadata["nbgrader"]
        return cell, resources


c.Autograde.sanitize_preprocessors = [
    preprocessors.ClearOutput,
    ForgetCopies,
    preprocessors.OverwriteKernelspec,
    preprocessors.OverwriteCells,
    preprocessors.CheckCellMetadata,
]

# Seconds for one cell. A check takes less than two; a loop where arrays would do may take its time.
c.Execute.timeout = 20
