# SPDX-License-Identifier: MIT
# A notebook as a script: the cells begin with "# %%", as Jupyter (Jupytext), VS Code and Spyder read them.
#
# usage: notebook.py VIDEO BOARD

# %% Take frames of a video with OpenCV
import sys

import alidade
import cv2
import matplotlib.pyplot as plt
import numpy as np

video, board = sys.argv[1], alidade.Board(sys.argv[2])
capture = cv2.VideoCapture(video)
frames = []
while len(frames) < 200:
    is_read, frame = capture.read()
    if not is_read:
        break
    frames.append(frame)
print(f"{len(frames)} frames of {video}")

# %% Calibrate from the arrays; images that show nothing new, or no board, are left out and listed
survey = alidade.detect(frames, board)
print(survey, *survey.reasons, sep="\n")
result = alidade.calibrate(survey)
print(result, *result.warnings, sep="\n")
result.save("camera.yaml")
result  # in a notebook: the findings and figures

# %% Project the board into the first view, and compare with the corners that were found there
view = result.views[0]
pixels, status = result.camera.project(board.points, view.camera_from_board)
print(f"{view.image}: {np.count_nonzero(status == alidade.Status.OK)} points, corners within {view.max_error_px:.2f} px")

# %% Draw the accuracy map: where in the image a projected point is how far off
accuracy = result.accuracy
figure, axes = plt.subplots(figsize=(8, 6))
drawn = axes.contourf(accuracy.pixels[..., 0], accuracy.pixels[..., 1], np.clip(accuracy.error_px, 0.01, 10),
                      levels=np.geomspace(0.01, 10, 13), norm="log")
axes.contour(accuracy.pixels[..., 0], accuracy.pixels[..., 1], accuracy.is_covered, levels=[0.5], colors="white")
axes.plot(pixels[:, 0], pixels[:, 1], "w+")
axes.set(title=f"within {accuracy.covered_px:.2g} px (95 %) where boards were seen (white line)", aspect="equal")
axes.invert_yaxis()
figure.colorbar(drawn, label="error of a projected point, 95 %, px")
figure.savefig("accuracy.png")
