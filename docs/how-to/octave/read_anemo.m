function record = read_anemo(file)
% READ_ANEMO  A recording of anemo as a struct of columns, in MATLAB or Octave.
%
%   record = read_anemo('run.csv')      a recording, or any table of anemo
%   record = read_anemo('run.mat')      what `anemo convert run.parquet -o run.mat` has written
%
% record.time_s, record.power_w_sector1, ... are columns of numbers, NaN where a cell is empty.
% record.event, record.state are cell arrays of text. Metadata is record.about, text by key: of a
% .csv file all of it, of a .mat file start_utc.

  if endsWith(file, '.mat')
    record = words_of_codes(load(file));
  elseif endsWith(file, '.csv')
    record = columns_of_text(file);
  else
    error('read_anemo: %s is neither .csv nor .mat: anemo convert makes .mat of .parquet', file);
  end
end

% The .mat file has text as numbers from 1 on, and the words that they mean.
function record = words_of_codes(loaded)
  record = struct('about', struct());
  names = fieldnames(loaded);
  for k = 1:numel(names)
    name = names{k};
    if endsWith(name, '_code')
      words = cellstr(loaded.([name(1:end - 4) 'words']));
      record.(name(1:end - 5)) = words(loaded.(name));
    elseif ~ischar(loaded.(name))
      record.(name) = loaded.(name);
    elseif ~endsWith(name, '_words')
      record.about.(name) = loaded.(name);
    end
  end
end

function record = columns_of_text(file)
  lines = strsplit(strrep(fileread(file), char(13), ''), char(10));
  lines(cellfun(@isempty, lines)) = [];
  remark = strncmp(lines, '#', 1);
  record = struct('about', about(lines(remark)));
  lines(remark) = [];
  names = strsplit(lines{1}, ',');
  cells = strsplit(strjoin(lines(2:end), ','), ',', 'CollapseDelimiters', false);
  if numel(cells) ~= numel(names) * (numel(lines) - 1)
    error('read_anemo: %s has a comma in a cell, or rows of another length: convert it to .mat', file);
  end
  cells = reshape(cells, numel(names), [])';
  for k = 1:numel(names)
    column = cells(:, k);
    numbers = str2double(column);
    % Text is what is neither a number nor empty.
    if any(isnan(numbers) & ~cellfun(@isempty, column) & ~strcmpi(column, 'nan'))
      record.(names{k}) = strrep(column, '"', '');
    else
      record.(names{k}) = numbers;
    end
  end
end

function texts = about(remarks)
  texts = struct();
  for k = 1:numel(remarks)
    parts = regexp(remarks{k}, '^#\s*([A-Za-z]\w*): (.*)$', 'tokens', 'once');
    if ~isempty(parts)
      texts.(parts{1}) = strrep(parts{2}, '\n', char(10));
    end
  end
end
