# SPDX-License-Identifier: BSD-3-Clause
"""One function for each figure: facts to a figure and its title."""
import math

from svg import BLACK, BLUE, GREEN, GREY, ORANGE, PALE, RED, SKY, SURFACES, Figure, Plot


def seen(figure, outlines, box, colours, opacity=0.45, stroke="#ffffff"):
    """The outlines of a view of 320x240 px in a box."""
    x, y, width, height = box
    place = lambda p: (x + min(width, max(0, p[0] * width / 320)), y + min(height, max(0, p[1] * height / 240)))
    for k, outline in enumerate(outlines):
        if len(outline) >= 3 and colours(k):
            figure.polygon([place(p) for p in outline], colours(k), stroke, 1, opacity)
    return place


def pipeline(facts):
    figure = Figure(760, 470)
    boxes = [(10, 30, 220, 165), (270, 30, 220, 165), (530, 30, 220, 165)]
    paired = [pair["indices"] for pair in facts["pairs"]]
    colour_of_scene = {scene: SURFACES[k % len(SURFACES)] for k, (scene, _) in enumerate(paired)}
    colour_of_model = {model: SURFACES[k % len(SURFACES)] for k, (_, model) in enumerate(paired)}
    for (x, y, width, height), title in zip(boxes, ("1  depth image", "2  its segments", "3  a local model, and the pairs")):
        figure.text(x, y - 10, title, 13, bold=True)
        figure.rectangle(x, y, width, height, "#f4f4f4", PALE, 1)
    figure.depth([row[::2] for row in facts["depth"][::2]], *boxes[0])
    scene = seen(figure, facts["outlines"], boxes[1], lambda k: colour_of_scene.get(k, PALE), 0.6)
    model = seen(figure, facts["model_outlines"], boxes[2], lambda k: colour_of_model.get(k, PALE), 0.6)
    figure.arrow((233, 112), (267, 112), GREY, 2)
    for pair in facts["pairs"]:
        begin, end = scene(pair["scene"]), model(pair["model"])
        figure.line([begin, end], BLACK, 1)
        for x, y in (begin, end):
            figure.circle(x, y, 2.5)

    figure.text(10, 235, "4  poses of all local models, as places in the map", 13, bold=True)
    plan(figure, facts, (10, 248, 350, 210))
    figure.text(400, 235, "5  ranked, with probabilities", 13, bold=True)
    bars = [(place["probability"], f"score {place['score']:.0f}, off by {place['off']:.2f} m", GREEN if place["off"] < 0.2 else GREY)
            for place in facts["places"][:5]]
    bars.append((facts["not_in_map"], "the map lacks the place", ORANGE))
    for k, (probability, words, colour) in enumerate(bars):
        y = 252 + 33 * k
        figure.text(414, y + 15, f"{k + 1}" if k + 1 < len(bars) else "–", 12, "end")
        figure.rectangle(422, y, 120, 20, "#f4f4f4")
        figure.rectangle(422, y, max(1, 120 * probability), 20, colour)
        figure.text(550, y + 15, f"{probability:.3f}", 12)
        figure.text(593, y + 15, words, 10, fill=GREY)
    return figure, f"From a depth image to ranked poses: an image of a simulated home, in a map of {len(facts['models'])} local models"


def plan(figure, facts, box):
    """The map from above: local models grey, places with the direction of view."""
    x, y, width, height = box
    everything = [m["at"] for m in facts["models"]] + [p["at"] for p in facts["places"]]
    low, high = [[f(p[i] for p in everything) for i in (0, 1)] for f in (min, max)]
    scale = min((width - 60) / (high[0] - low[0]), (height - 60) / (high[1] - low[1]))
    place = lambda p: (x + width / 2 + scale * (p[0] - (low[0] + high[0]) / 2), y + height / 2 - scale * (p[1] - (low[1] + high[1]) / 2))
    figure.rectangle(x, y, width, height, "#fafafa", PALE, 1)

    def camera(one, colour, length, line, head):
        begin = place(one["at"])
        norm = math.hypot(*one["axis"][:2])
        figure.arrow(begin, (begin[0] + length * one["axis"][0] / norm, begin[1] - length * one["axis"][1] / norm), colour, line, head)
        figure.circle(*begin, line + 0.5, colour)

    for model in facts["models"]:
        px, py = place(model["at"])
        norm = math.hypot(*model["axis"][:2])
        figure.line([(px, py), (px + 8 * model["axis"][0] / norm, py - 8 * model["axis"][1] / norm)], "#b0b0b0", 1)
    for rank, one in reversed(list(enumerate(facts["places"][:5]))):
        camera(one, GREEN if one["off"] < 0.2 else BLUE, 20, 2.2, 7)
        if rank == 0:
            px, py = place(one["at"])
            figure.text(px - 10, py + 8, "1", 13, "end", GREEN, True, True)
    figure.text(x + 8, y + 16, "grey: local models", 10, fill=GREY, halo=True)
    figure.text(x + 8, y + 30, "blue: places 2 to 5", 10, fill=BLUE, halo=True)
    figure.line([(x + width - 8 - 2 * scale, y + height - 12), (x + width - 8, y + height - 12)], BLACK, 2)
    figure.text(x + width - 8 - scale, y + height - 17, "2 m", 10, "middle", halo=True)


def split(facts):
    figure = Figure(760, 250)
    boxes = [(10, 34, 236, 177), (262, 34, 236, 177), (514, 34, 236, 177)]
    for (x, y, width, height), title in zip(boxes, ("1  depth image", "2  flat squares of 4 to 64 px", "3  merged and labelled")):
        figure.text(x, y - 12, title, 13, bold=True)
        figure.rectangle(x, y, width, height, "#f4f4f4", PALE, 1)
    figure.depth([row[::2] for row in facts["depth"][::2]], *boxes[0])
    x, y, width, height = boxes[1]
    corners = lambda u, v: (x + min(u, 320) * width / 320, y + min(v, 240) * height / 240)
    for size, colour in ((4, RED), (8, ORANGE), (16, GREEN), (32, SKY), (64, BLUE)):
        squares = [corners(u, v) + corners(u + size, v + size) for u, v, s in facts["leaves"] if s == size]
        figure.squares(squares, colour)
    palette = ["#ffffff"] + (SURFACES + ["#888888", "#004d73", "#a06f00", "#006b4f", "#8a4f6f", "#2f7ea8", "#8f3f00"])[:14]
    colours = [bytes.fromhex(colour[1:]) for colour in palette]
    figure.raster([[1 + (label - 1) % (len(colours) - 1) if label else 0 for label in row] for row in facts["labels"]], colours, *boxes[2])
    figure.text(10, 234, f"{len(facts['leaves'])} squares, the smallest red, the largest blue; what is not flat belongs to none. {facts['segments']} segments.", 11)
    return figure, "A simulated depth image, its quad-tree, and its segments"


def segment(facts):
    figure = Figure(760, 350)
    box = (10, 40, 320, 240)
    figure.text(10, 24, "A segment and its frame", 13, bold=True)
    figure.depth(facts["depth"], *box)
    place = seen(figure, facts["outlines"], box, lambda k: SKY if k != facts["segment"] else ORANGE, 0.25)
    seen(figure, [facts["outlines"][facts["segment"]]], box, lambda _: ORANGE, 0.5, ORANGE)
    figure.line([place(p) for p in facts["ellipse"] + facts["ellipse"][:1]], BLACK, 1.5, "4 2")
    origin, *ends = facts["axes"]
    for end, name, colour in zip(ends, ("x", "y", "–n"), (BLUE, GREEN, RED)):
        figure.arrow(place(origin), place(end), colour, 2.5, 8)
        dx, dy = end[0] - origin[0], end[1] - origin[1]
        length = math.hypot(dx, dy)
        tx, ty = place((end[0] + 12 * dx / length, end[1] + 12 * dy / length))
        figure.text(tx, ty + 4, name, 14, "middle", colour, True, True)
    (l1, l2) = facts["lambda"]
    figure.text(10, 300, f"origin: the centroid; axes 0.5 m long; support {facts['support']} px", 11)
    figure.text(10, 317, f"dashed: 1 std of the points, {math.sqrt(l1):.2f} m along x, {math.sqrt(l2):.2f} m along y (Σp)", 11)
    figure.text(10, 334, "–n: towards the camera, as n points away from it", 11)

    plot = Plot(figure, (410, 40, 335, 240), (facts["x"][0], facts["x"][-1]), (-50, 50))
    reach = [round(0.25 * k, 2) for k in range(-4, 5) if facts["x"][0] <= 0.25 * k <= facts["x"][-1]]
    plot.axes("position along x of the frame [m]", "plane in the image beyond the true plane [mm]", reach, (-40, -20, 0, 20, 40))

    def deviation(covariance):
        return [1000 * math.sqrt(covariance[2][2] - 2 * x * covariance[0][2] + x * x * covariance[0][0]) for x in facts["x"]]

    full, paper = deviation(facts["Sigma_q"]), deviation(facts["Sigma_q_paper"])
    figure.polygon(plot.path([(x, 2 * s) for x, s in zip(facts["x"], full)] + [(x, -2 * s) for x, s in reversed(list(zip(facts["x"], full)))]),
                   ORANGE, opacity=0.35)
    for plane in facts["planes"]:
        figure.line([plot.path([(x, 1000 * value)])[0] for x, value in list(zip(facts["x"], plane))[::len(plane) - 1]], BLUE, 0.8, opacity=0.5)
    for sign in (-1, 1):
        figure.line(plot.path([(x, sign * 2 * s) for x, s in zip(facts["x"], paper)]), BLACK, 1.3, "5 3")
    inside = [abs(1000 * value) <= 2 * s for plane in facts["planes"] for value, s in zip(plane, full)]
    figure.text(420, 58, f"blue: {len(facts['planes'])} cameras, each with its own errors", 11, halo=True)
    figure.text(420, 270, f"orange: 2 std of Σq, holds {100 * sum(inside) / len(inside):.1f} % of them", 11, halo=True)
    figure.text(410, 334, "dashed: 2 std by Eqs. (4)-(5) of the paper", 11)
    return figure, "A segment of a simulated image with its frame, and where 60 simulated cameras see its plane"


def tree(facts):
    figure = Figure(760, 560)
    scene, model = name_surfaces(facts["scene"], "abcd"), name_surfaces(facts["model"], "ABCD")
    colours = dict(zip("abcd", SURFACES))
    figure.text(10, 22, "The image", 13, bold=True)
    figure.text(230, 22, "The local model", 13, bold=True)
    for x, outlines, names in ((10, facts["scene_outlines"], scene), (230, facts["model_outlines"], model)):
        box = (x, 32, 200, 150)
        figure.rectangle(*box, "#f4f4f4", PALE, 1)
        place = seen(figure, outlines, box, lambda k, names=names: colours[names[k].lower()], 0.6)
        for k, outline in enumerate(outlines):
            px, py = place([sum(p[i] for p in outline) / len(outline) for i in (0, 1)])
            figure.text(px, py + 5, names[k], 15, "middle", bold=True, halo=True)
    order = ", ".join(scene[node["scene"]] + model[node["model"]] for node in facts["root"]["children"])
    for k, words in enumerate(("a, A: floor. b, B: wall ahead. c, C: wall on the left.",
                               "D: front of a cupboard that was taken away since.",
                               f"Candidates in the order of the search: {order}.",
                               "Each box is a Kalman update: its cost, and the",
                               "largest standard deviations of the pose after it.",
                               "After bD, overlap (4.2) rejects cC: the wall c would",
                               "lie beside C. So aA, cC, bB is what is left.")):
        figure.text(445, 44 + 20 * k, words, 11)

    def leaves(node):
        return max(1, sum(leaves(child) for child in node["children"]))

    def draw(node, left, depth, parent):
        width = 124 * leaves(node)
        x, y = left + width / 2, 215 + 86 * depth
        if parent:
            figure.line([parent, (x, y)], GREY if node["accepted"] else RED, 1.2, None if node["accepted"] else "4 3")
        colour = BLACK if not parent else GREEN if node["complete"] else BLACK if node["accepted"] else RED
        figure.rectangle(x - 57, y, 114, 56, "#e9f6f1" if node.get("complete") else "#ffffff", colour, 2.5 if node.get("complete") else 1.2, 5)
        known = f"{node['rotation_deg']:.1f} deg, {node['translation']:.2f} m"
        if not parent:
            figure.text(x, y + 22, "prior", 13, "middle", bold=True)
            figure.text(x, y + 41, known, 11, "middle")
        else:
            figure.text(x, y + 17, scene[node["scene"]] + model[node["model"]], 13, "middle", colour, True)
            figure.text(x, y + 33, f"cost {node['cost']:.1f}" if node["accepted"] else f"overlap {node['overlap']:.1f} > 11.3", 10.5, "middle", colour)
            figure.text(x, y + 48, known if not node["complete"] else known + " ✓", 10.5, "middle", colour if node["accepted"] else GREY)
        for child in node["children"]:
            draw(child, left, depth + 1, (x, y + 56))
            left += 124 * leaves(child)

    draw(facts["root"], (760 - 124 * leaves(facts["root"])) / 2, 0, None)
    return figure, "The tree of pairs of a corner of three planes, one of which the model shows twice"


def name_surfaces(surfaces, letters):
    names = []
    for surface in surfaces:
        x, y, z = surface["normal"]
        names.append(letters[0] if z < -0.7 else letters[2] if x < -0.7 else letters[1] if surface["centroid"][1] > 7.8 else letters[3])
    return names


VERDICTS = {"a": BLUE, "c": RED, "o": "#999999", ".": "#eeeeee"}


def verdicts(facts):
    figure = Figure(760, 505)
    for left, key, title in ((10, "right", "At the right pose: a new box stands in the room"), (390, "wrong", "At a pose that is wrong by 0.46 m")):
        judged = facts[key]
        figure.text(left, 22, title, 13, bold=True)
        box = (left, 32, 360, 250)
        figure.rectangle(*box, "#fafafa", PALE, 1)
        place = lambda p, left=left: (left + 10 + 56 * (p[0] - 0.6), 32 + 245 - 56 * (p[1] - 0.8))
        inside = lambda p, left=left: left <= place(p)[0] <= left + 360 and 32 <= place(p)[1] <= 282
        run = []
        for p in facts["surface"] + [None]:
            if p and inside(p) and run and math.dist(p, run[-1]) < 0.25:
                run.append(p)
                continue
            if len(run) > 1:
                figure.line([place(q) for q in run], BLACK, 1.6)
            run = [p] if p and inside(p) else []
        for p in judged["slice"][::2]:
            if inside(p) and p[2] in "co":
                figure.line([place(facts["camera"]), place(p)], VERDICTS[p[2]], 0.7, opacity=0.6)
        for p in judged["slice"]:
            if inside(p) and p[2] != ".":
                figure.circle(*place(p), 2.6, VERDICTS[p[2]])
        bx, by = place(facts["camera"])
        figure.circle(bx, by, 5, BLACK)
        figure.text(bx - 9, by + 4, "B", 13, "end", bold=True)
        ax, ay = place(judged["camera"])
        figure.arrow((ax, ay), (ax + 26 * judged["axis"][0], ay - 26 * judged["axis"][1]), GREEN, 2.2)
        figure.circle(ax, ay, 5, GREEN)
        figure.text(ax - 8, ay + 15, "A", 13, "end", GREEN, True)
        for row, line in enumerate(judged["rows"]):
            begin = 0
            for end in range(1, len(line) + 1):
                if end == len(line) or line[end] != line[begin]:
                    figure.rectangle(left + 5.4 * begin, 300 + 5.4 * row, 5.4 * (end - begin), 5.4, VERDICTS[line[begin]], crisp=True)
                    begin = end
        total = judged["agree"] + judged["contradict"] + judged["occluded"]
        for k, (letter, name) in enumerate((("a", "agree"), ("c", "contradict"), ("o", "occluded"))):
            y = 325 + 34 * k
            number = judged[name]
            figure.rectangle(left + 232, y, 14, 14, VERDICTS[letter])
            figure.text(left + 252, y + 12, f"{name} {100 * number / total:.0f} %", 12)
        figure.text(left + 232, 440, "all pixels of A on", 11, fill=GREY)
        figure.text(left + 232, 455, "the fine grid", 11, fill=GREY)
    figure.text(10, 488, "Above: the slice at the height of the cameras, seen from above. Black: what B has measured. Dots: what A shows, moved by the pose.", 11)
    return figure, "Pixels of image A that agree with, contradict or are occluded in image B"


def direction(facts):
    figure = Figure(760, 350)
    for left, key, title in ((60, "bare", "A bare corridor: nothing decides"), (435, "doors", "Niches every 1.8 m: several answers")):
        plot = Plot(figure, (left, 60, 310, 220), (-3, 3), (-60, 4))
        figure.text(left, 24, title, 13, bold=True)
        plot.axes("motion along the corridor [m]", "log likelihood of the pixels [nats]", range(-3, 4), range(-60, 1, 20))
        truth = facts[key]["truth"]
        figure.line([plot.at(truth, -60), plot.at(truth, 4)], GREY, 1.2, "3 3")
        figure.text(plot.at(truth, 0)[0] + 3, 76, "true", 11, fill=GREY)
        figure.line(plot.path(facts[key]["curve"]), BLUE, 2)
        modes = facts[key]["modes"]
        likeliest = modes[:1] if key == "bare" else modes
        for k, mode in enumerate(likeliest):
            x, y = plot.at(mode["y"], -50 if key == "bare" else -54)
            begin, end = (plot.at(max(-3, min(3, mode["y"] + sign * 2 * mode["std"])), 0)[0] for sign in (-1, 1))
            figure.line([(begin, y), (end, y)], RED, 2.5)
            figure.circle(x, y, 4.5, RED)
            figure.text(x, y - 10, f"{mode['std']:.2f} m std" if key == "bare" else f"{mode['probability']:.2f}", 12, "middle", RED, True, True)
    figure.text(60, 341, "Red: the answers of CameraMotion, with 2 standard deviations, or with their probabilities; the prior is no motion, 1.4 m.", 11)
    return figure, "The likelihood of a motion along a corridor, without and with equal niches"


def belief(facts):
    figure = Figure(760, 345)
    begin = facts[0]["time"]
    times = [image["time"] - begin for image in facts]
    plot = Plot(figure, (50, 60, 560, 215), (0, times[-1]), (0, 1))
    below = [0.0] * len(facts)
    for key, colour in (("right", GREEN), ("others", ORANGE), ("not_in_map", PALE)):
        above = [low + image[key] for low, image in zip(below, facts)]
        figure.polygon(plot.path(list(zip(times, above)) + list(zip(times, below))[::-1]), colour, "#ffffff", 0.8)
        below = above
    plot.axes("time [s]", "", range(0, int(times[-1]) + 1, 2), (0, 0.25, 0.5, 0.75, 1))
    figure.line([plot.at(0, 0.9), plot.at(times[-1], 0.9)], BLACK, 1, "5 3")
    for key, colour, y, words in (("right", GREEN, 240, "the right place"), ("others", ORANGE, 160, "other places"), ("not_in_map", "#999999", 85, "the map lacks it")):
        figure.text(620, y, words, 12, fill=colour, bold=True)
    for image, time in zip(facts, times):
        x, _ = plot.at(time, 0)
        figure.rectangle(x - 1.5, 45, 3, 9, {"sure": GREEN, "doubtful": ORANGE, "unknown": PALE}[image["state"]])
    figure.text(620, 54, "answers", 11, fill=GREY)
    figure.text(16, 172, "probability", 12, "middle", turn=-90)
    turning = [math.dist(a["at"], b["at"]) < 0.1 for a, b in zip(facts, facts[1:])]
    begin = 0
    for end in range(1, len(turning) + 1):
        if end == len(turning) or turning[end] != turning[begin]:
            if times[end] - times[begin] > 1:
                x, _ = plot.at((times[begin] + times[end]) / 2, 0)
                figure.text(x, 78, "turns on the spot" if turning[begin] else "drives", 11, "middle", halo=True)
            begin = end
    first = next((t for image, t in zip(facts, times) if image["state"] == "sure"), None)
    if first is not None:
        figure.line([plot.at(first, 0), plot.at(first, 1)], BLACK, 1.2)
        figure.text(plot.at(first, 0)[0] + 4, 268, "sure", 12, bold=True)
    figure.text(50, 22, "A drive into a room of a hotel of equal rooms, and out again", 13, bold=True)
    figure.text(50, 336, "Marks above: the answer to each image, sure (green), doubtful (orange), unknown (grey). Dashed: a place is sure from 0.9.", 11)
    return figure, "Belief over places during a drive through a simulated hotel of equal rooms"
