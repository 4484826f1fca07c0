function outputs = predict_anemo(model, record)
% PREDICT_ANEMO  What a model of anemo predicts of a record, from rest: a column an output.
%
%   model = jsondecode(fileread('model.json'));
%   outputs = predict_anemo(model, read_anemo('run.csv'));
%
%   x_k <- x_k + g_k (u - x_k),   g_k = 1 - exp(-rate_k Ts),   y = offset + sum R_k x_k + D u
%
% Exact for inputs that are held from row to row: what `anemo validate --start rest` computes, for
% models of structure `symbol` that follow no surroundings and have no growing losses.

  for key = {'wind', 'ambient', 'losses'}
    if isfield(model, key{1}) && ~isempty(model.(key{1}))
      error('predict_anemo: the model has `%s`, which these steps leave out: use anemo validate', key{1});
    end
  end
  Ts = model.sample_period_s;
  if any(abs(diff(record.time_s) - Ts) > 0.01 * Ts)
    error('predict_anemo: rows are not always %g s apart: take a part without gaps', Ts);
  end
  names = cell(1, numel(model.outputs));
  for k = 1:numel(names)
    output = item(model.outputs, k);
    names{k} = output.name;
    outputs(:, k) = output.offset_c + zeros(size(record.time_s));
  end
  for k = 1:numel(model.pairs)
    pair = item(model.pairs, k);
    at = strcmp(pair.output, names);
    labels = fieldnames(pair.classes);
    for j = 1:numel(labels)
      class = pair.classes.(labels{j});
      u = record.(pair.input);
      if numel(labels) > 1
        % Every class is driven in its own intervals, and decays in the others.
        u = u .* strcmp(matlab.lang.makeValidName(record.(model.event_column)), labels{j});
      end
      u = [zeros(pair.dead_time_samples, 1); u(1:end - pair.dead_time_samples)];
      for m = 1:numel(pair.mesh_rad_s)
        g = -expm1(-pair.mesh_rad_s(m) * Ts);
        outputs(:, at) = outputs(:, at) + class.r_k_per_w(m) * filter([0, g], [1, g - 1], u);
      end
      outputs(:, at) = outputs(:, at) + class.feed_through_k_per_w * u;
    end
  end
end

% Objects of a list are a struct array if all have the same keys, else a cell array.
function one = item(list, k)
  if iscell(list)
    one = list{k};
  else
    one = list(k);
  end
end
