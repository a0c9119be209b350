"""The paper's policy: its algorithms 1 to 5, and its tables beside what they compute here.

Kyaw, Smith, Jeon and Gershenfeld, *Speech to Reality: On-Demand Production using Natural Language,
3D Generative AI, and Discrete Robotic Assembly*, SCF '25, doi:10.1145/3745778.3766670.

| module | what it is |
|---|---|
| ``scaling`` | algorithm 1 up to its grid, and the two ways in which the others scale down |
| ``counting`` | algorithm 2: fewer parts |
| ``steadying`` | algorithm 3: overhangs and stacks |
| ``sequencing`` | algorithm 4: the order |
| ``square_path`` | algorithm 5: the arm's way, and how long it takes |
| ``policy`` | all of them on one shape, and what is refused |
| ``objects``, ``printed`` | the paper's four objects, and its figures as printed |
| ``workbench`` | those objects taken through those algorithms |
| ``tables``, ``performance``, ``claims`` | printed figures beside the computed ones |
| ``report``, ``comparing`` | the values of such tables, and all of them by name |
"""

from cellctl.validating.paper.policy import PaperPlan, plan_paper, plan_paper_cells

__all__ = ["PaperPlan", "plan_paper", "plan_paper_cells"]
