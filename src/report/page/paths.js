// How the Euclidean truth differs from the geodesic one, split by the ways that light takes.

const lightPaths = list(results.light_paths);

function pathRow(name, part) {
  return [
    name, percent((part || {}).rms), percent((part || {}).mean), percent((part || {}).quadrature_error)
  ];
}

function pathTable(c) {
  const paths = lightPaths.find((entry) => entry.view === c.view && entry.profile === c.profile);
  if (!paths) return null;
  const title = h('h3', {}, 'Light by the way that it takes');
  if (paths.not_computed)
    return h('div', {class: 'panel card'}, title, h('p', {class: 'muted'}, paths.not_computed));
  const check = paths.sum_check || {};
  return h(
      'div', {class: 'panel card'}, title,
      h('p', {class: 'muted'}, 'Raw Euclidean less raw geodesic truth at ',
        plural(paths.points || 0, 'pixel'),
        ' drawn at random, of luminance, as shares of the Euclidean truth\u2019s RMS there. Transmittance: farther along ',
        'the surface than r_max = ', number(paths.r_max_mm),
        ' mm, the straight way inside the body. Air: the straight ',
        'way leaves it, as across a crease. Curvature: within r_max along the surface, and nearer straight. They sum to ',
        'the difference of the two truths but for ', scientific(check.max_difference),
        ' of the largest irradiance (allowed: ', scientific(check.allowed),
        '). Last row: geodesic light beyond r_max, which a cut-off leaves out and which is in none of them.'),
      plainTable(['Part', 'RMS', 'mean', 'quadrature error, RMS'], [
        pathRow('transmittance', paths.transmittance), pathRow('air', paths.air),
        pathRow('curvature', paths.curvature), pathRow('sum', paths.sum),
        pathRow('beyond r_max', paths.beyond_r_max)
      ]));
}
