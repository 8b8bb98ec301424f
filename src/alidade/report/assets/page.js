'use strict';
// The page shows everything without this script. The script opens views, and tells values under the pointer.
(() => {
  const byId = (id) => document.getElementById(id);
  const threeDigits = (value) => value === 0 ? '0' : value.toFixed(Math.max(0, Math.min(6, 2 - Math.floor(Math.log10(Math.abs(value))))));
  const evidence = JSON.parse(byId('evidence').textContent);
  // Of a calibration, of a rig camera by camera, or of all cameras of a validation that were tested on images.
  const views = evidence.files ? [] : evidence.views || [];
  for (const file of evidence.files || []) {
    for (const camera of file.cameras) {
      for (const view of camera.held_out ? camera.held_out.views : []) {
        if (view.corners.length) views.push({...view, size: camera.image_size, of: camera.held_out.rms_px});
      }
    }
  }
  if (evidence.kind === 'rig') {
    views.sort((a, b) => a.camera - b.camera);
    for (const view of views) {
      const camera = evidence.cameras[view.camera];
      view.size = camera.image_size;
      view.of = camera.rms_px;
      view.num_corners = view.corners.length;
      view.max_error_px = Math.max(...view.corners.map((c) => Math.hypot(c.dx, c.dy)));
    }
  }
  const sizeOf = (view) => view.size || evidence.image_size;

  const svgElement = (name, attributes) => {
    const element = document.createElementNS('http://www.w3.org/2000/svg', name);
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
    return element;
  };
  const path = (kind, d, width) => svgElement('path', {class: kind, d, 'stroke-width': width});

  // ---- a view, large ----

  const dialog = byId('viewer');
  let shown = 0;

  const drawView = () => {
    const view = views[shown];
    const size = sizeOf(view);
    const drawing = byId('viewer-drawing');
    drawing.setAttribute('viewBox', `-0.5 -0.5 ${size.width} ${size.height}`);
    // A unit of about 2 px on the screen, however large the image is drawn.
    const box = drawing.getBoundingClientRect();
    const unit = 2 * Math.max(size.width / (box.width || 800), size.height / (box.height || 600));
    const times = Number(byId('viewer-times').value);
    drawing.replaceChildren();
    const picture = document.querySelector(`.thumb[data-view="${shown}"] img`);
    if (picture) {
      drawing.append(svgElement('image', {href: picture.src, x: -0.5, y: -0.5, width: size.width,
                                          height: size.height, preserveAspectRatio: 'none'}));
    }
    let detected = '';
    let projected = '';
    const r = 2.4 * unit;
    for (const c of view.corners) {
      detected += `M${c.u - r},${c.v}a${r},${r} 0 1 0 ${2 * r},0a${r},${r} 0 1 0 ${-2 * r},0`;
      const x = c.u + times * c.dx;
      const y = c.v + times * c.dy;
      projected += `M${c.u},${c.v}L${x},${y}M${x - unit},${y - unit}l${2 * unit},${2 * unit}m0,${-2 * unit}l${-2 * unit},${2 * unit}`;
    }
    const outliers = (evidence.outliers || []).filter((o) => o.image === view.image && o.board === view.board && 'u' in o);
    let rejected = '';
    for (const o of outliers) {
      const d = 1.4 * r;
      rejected += `M${o.u - d},${o.v}l${d},${-d}l${d},${d}l${-d},${d}zM${o.u},${o.v}l${o.dx},${o.dy}`;
    }
    drawing.append(path('rejected', rejected, 0.9 * unit));
    byId('viewer-key').textContent =
        (times > 1 ? `circle: detected; cross: end of its error, drawn ${times} times longer` : 'circle: detected; cross: projected') +
        (outliers.length ? '; diamond: left out as an outlier, its line as long as the error' : '');
    drawing.append(path('detected', detected, 0.7 * unit), path('projected', projected, 0.7 * unit));
    byId('viewer-name').textContent = view.image;
    byId('viewer-words').textContent =
        `view ${shown + 1} of ${views.length}, ${view.num_corners} corners${outliers.length ? `, ${outliers.length} left out` : ''}, ` +
        `RMS ${threeDigits(view.rms_px)} px, largest ${threeDigits(view.max_error_px)} px`;
  };
  const show = (index) => {
    shown = (index + views.length) % views.length;
    if (!dialog.open) {
      // Errors are drawn as long as they can be without hiding the board.
      const size = sizeOf(views[shown]);
      const longest = 0.03 * Math.max(size.width, size.height);
      const usual = views[shown].of || evidence.rms_px;
      const times = byId('viewer-times');
      times.value = [...times.options].map((o) => o.value).reverse().find((t) => t * usual <= longest) || '1';
      dialog.showModal();
    }
    drawView();
  };
  if (dialog) {
    document.addEventListener('click', (event) => {
      const opener = event.target.closest('[data-view]');
      const endsDrag = wasDragged && scene && scene.contains(event.target);
      wasDragged = false;
      if (opener && !endsDrag) show(Number(opener.dataset.view));
    });
    byId('viewer-before').addEventListener('click', () => show(shown - 1));
    byId('viewer-after').addEventListener('click', () => show(shown + 1));
    byId('viewer-close').addEventListener('click', () => dialog.close());
    addEventListener('resize', () => { if (dialog.open) drawView(); });
    byId('viewer-times').addEventListener('change', drawView);
    dialog.addEventListener('click', (event) => { if (event.target === dialog) dialog.close(); });
    dialog.addEventListener('keydown', (event) => {
      if (event.target.tagName === 'SELECT') return;
      if (event.key === 'ArrowLeft') show(shown - 1);
      if (event.key === 'ArrowRight') show(shown + 1);
    });
  }

  // ---- a file of several ----

  const openFold = () => {
    const fold = /^#(file|camera)\d/.test(location.hash) && byId(location.hash.slice(1));
    if (fold && fold.tagName === 'DETAILS') { fold.open = true; fold.scrollIntoView(); }
  };
  addEventListener('hashchange', openFold);
  openFold();

  // ---- boards and camera in space ----

  const scene = byId('scene-drawing');
  const shapes = scene ? [...scene.querySelectorAll('[data-points]')].map((element) => {
    const numbers = element.dataset.points.split(' ').map(Number);
    const points = [];
    for (let i = 0; i < numbers.length; i += 3) points.push(numbers.slice(i, i + 3));
    return {element, points, isClosed: /Z\s*$/.test(element.getAttribute('d') || '')};
  }) : [];
  const radians = (degrees) => degrees * Math.PI / 180;
  let yaw = scene ? Number(scene.dataset.yaw) : 0;
  let pitch = scene ? Number(scene.dataset.pitch) : 0;
  let zoom = 1;

  const drawScene = () => {
    const [cy, sy, cp, sp] = [Math.cos(radians(yaw)), Math.sin(radians(yaw)), Math.cos(radians(pitch)), Math.sin(radians(pitch))];
    const middle = scene.dataset.middle.split(' ').map(Number);
    const [left, top] = scene.dataset.at.split(' ').map(Number);
    const scale = zoom * Number(scene.dataset.scale);
    const turned = ([px, py, pz]) => {
      const [x, y, z] = [px - middle[0], py - middle[1], pz - middle[2]];
      const far = cy * z - sy * x;
      return [left + scale * (cy * x + sy * z), top + scale * (cp * y - sp * far), sp * y + cp * far];
    };
    for (const shape of shapes) {
      const points = shape.points.map(turned);
      shape.depth = points.reduce((sum, p) => sum + p[2], 0) / points.length;
      if (shape.element.tagName === 'text') {
        shape.element.setAttribute('x', points[0][0].toFixed(2));
        shape.element.setAttribute('y', points[0][1].toFixed(2));
      } else {
        shape.element.setAttribute('d', points.map((p, i) => `${i ? 'L' : 'M'}${p[0].toFixed(2)},${p[1].toFixed(2)}`).join('') +
                                        (shape.isClosed ? 'Z' : ''));
      }
    }
    const boards = scene.querySelector('.boards');
    // Far shapes first, so that near ones cover them.
    shapes.filter((s) => s.element.parentElement === boards).sort((a, b) => b.depth - a.depth)
        .forEach((s) => boards.append(s.element));
  };
  const turn = (dYaw, dPitch) => {
    yaw += dYaw;
    pitch = Math.max(-90, Math.min(90, pitch + dPitch));
    drawScene();
  };
  let wasDragged = false;
  if (scene) {
    let last = null;
    scene.addEventListener('pointerdown', (event) => { last = [event.clientX, event.clientY]; wasDragged = false; });
    addEventListener('pointermove', (event) => {
      if (!last) return;
      const [dx, dy] = [event.clientX - last[0], event.clientY - last[1]];
      if (!wasDragged && Math.hypot(dx, dy) < 4) return;
      wasDragged = true;
      last = [event.clientX, event.clientY];
      turn(-0.5 * dx, 0.5 * dy);
    });
    addEventListener('pointerup', () => { last = null; });
    addEventListener('pointercancel', () => { last = null; });
    scene.addEventListener('keydown', (event) => {
      const steps = {ArrowLeft: [6, 0], ArrowRight: [-6, 0], ArrowUp: [0, -6], ArrowDown: [0, 6]};
      if (steps[event.key]) turn(...steps[event.key]);
      else if (event.key === '+' || event.key === '-') { zoom *= event.key === '+' ? 1.2 : 1 / 1.2; drawScene(); }
      else return;
      event.preventDefault();
    });
  }

  // ---- paper shows all ----

  const closed = [];
  addEventListener('beforeprint', () => {
    for (const details of document.querySelectorAll('details:not([open])')) {
      details.open = true;
      closed.push(details);
    }
  });
  addEventListener('afterprint', () => { for (const details of closed.splice(0)) details.open = false; });

  // ---- the value under the pointer ----

  const tip = document.createElement('div');
  tip.className = 'tip';
  tip.hidden = true;
  document.body.append(tip);
  const tell = (event, words) => {
    tip.textContent = words;
    tip.hidden = false;
    const box = tip.getBoundingClientRect();
    tip.style.left = `${Math.min(event.clientX + 14, innerWidth - box.width - 8)}px`;
    tip.style.top = `${event.clientY + 18}px`;
  };
  const pixels = (value) => value === null ? 'no ray' : `${Number(value.toPrecision(2))} px`;

  for (const map of document.querySelectorAll('[data-map]')) {
    const [left, top, right, bottom] = map.dataset.box.split(' ').map(Number);
    const fold = map.closest('[data-camera]');
    const {accuracy, image_size: size} = fold ? evidence.cameras[fold.dataset.camera] : evidence;
    map.addEventListener('pointermove', (event) => {
      const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(map.getScreenCTM().inverse());
      const x = (at.x - left) / (right - left);
      const y = (at.y - top) / (bottom - top);
      if (x < 0 || x > 1 || y < 0 || y > 1) { tip.hidden = true; return; }
      const {columns, rows, error_px: errors} = accuracy;
      const error = errors[Math.round(y * (rows - 1)) * columns + Math.round(x * (columns - 1))];
      tell(event, `pixel (${Math.round(x * size.width - 0.5)}, ${Math.round(y * size.height - 0.5)}): ${pixels(error)}`);
    });
    map.addEventListener('pointerleave', () => { tip.hidden = true; });
  }
  document.addEventListener('pointerover', (event) => {
    const teller = event.target.closest('[data-tell]');
    const bar = event.target.closest('rect[data-view], path[data-view]');
    if (teller) {
      tell(event, teller.dataset.tell);
    } else if (bar) {
      const view = views[Number(bar.dataset.view)];
      tell(event, `${view.image}: RMS ${threeDigits(view.rms_px)} px, largest ${threeDigits(view.max_error_px)} px`);
    } else if (!event.target.closest('[data-map]')) {
      tip.hidden = true;
    }
  });
})();
